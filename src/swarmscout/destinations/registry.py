"""Selectors by name: see :mod:`swarmscout.core.registry`.

Other packages register theirs under the entry point group ``swarmscout.selectors``.
"""

from __future__ import annotations

from swarmscout.core.errors import SelectorError
from swarmscout.core.registry import Registry
from swarmscout.destinations.selector import Selector

__all__ = ["RECOMMENDED", "SELECTORS", "make_selector", "model_selectors", "selectors"]

RECOMMENDED = "multi-criteria"
"""The selector to start with if you have no preference."""

_HERE = "swarmscout.destinations"
_WITH_MODELS = ("llm", "llm-shortlist", "shortlist-random")

SELECTORS: Registry[Selector] = Registry(
    noun="selector",
    method="choose(view, memory)",
    face=Selector,  # type: ignore[type-abstract]
    error=SelectorError,
    group="swarmscout.selectors",
    built_in={
        "random": f"{_HERE}.random:Random",
        "quantile": f"{_HERE}.quantile:Quantile",
        "quantile-local": f"{_HERE}.quantile_local:QuantileLocal",
        "nearest": f"{_HERE}.nearest:Nearest",
        "nearest-euclidean": f"{_HERE}.nearest_euclidean:NearestEuclidean",
        "utility": f"{_HERE}.utility:Utility",
        "information-gain": f"{_HERE}.information_gain:InformationGain",
        "minpos": f"{_HERE}.minpos:MinPos",
        "hungarian": f"{_HERE}.hungarian:Hungarian",
        "voronoi": f"{_HERE}.voronoi:Voronoi",
        "potential": f"{_HERE}.potential:Potential",
        "llm-like": f"{_HERE}.llm_like:LlmLike",
        "multi-criteria": f"{_HERE}.multi_criteria:MultiCriteria",
        "llm": f"{_HERE}.llm.llm:Llm",
        "llm-shortlist": f"{_HERE}.llm.shortlist:LlmShortlist",
        "shortlist-random": f"{_HERE}.llm.shortlist:ShortlistRandom",
    },
)


def selectors() -> dict[str, str]:
    """Names of the selectors that use no language model, each with one line on what it does."""
    return {name: line for name, line in SELECTORS.names().items() if name not in _WITH_MODELS}


def model_selectors() -> dict[str, str]:
    """Names of the LLM-based selectors and of their control, each with one line."""
    return {name: line for name, line in SELECTORS.names().items() if name in _WITH_MODELS}


make_selector = SELECTORS.make
