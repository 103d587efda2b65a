"""Selectors by name: see :mod:`swarmscout.core.registry`.

Other packages register theirs under the entry point group ``swarmscout.selectors``.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from swarmscout.core.errors import SelectorError
from swarmscout.core.registry import Registry
from swarmscout.destinations.hungarian import Hungarian
from swarmscout.destinations.information_gain import InformationGain
from swarmscout.destinations.llm.llm import Llm
from swarmscout.destinations.llm.shortlist import LlmShortlist, ShortlistRandom
from swarmscout.destinations.llm_like import LlmLike
from swarmscout.destinations.minpos import MinPos
from swarmscout.destinations.multi_criteria import MultiCriteria
from swarmscout.destinations.nearest import Nearest
from swarmscout.destinations.nearest_euclidean import NearestEuclidean
from swarmscout.destinations.potential import Potential
from swarmscout.destinations.quantile import Quantile
from swarmscout.destinations.quantile_local import QuantileLocal
from swarmscout.destinations.random import Random
from swarmscout.destinations.selector import Selector
from swarmscout.destinations.utility import Utility
from swarmscout.destinations.voronoi import Voronoi

__all__ = ["RECOMMENDED", "SELECTORS", "make_selector", "model_selectors", "selectors"]

RECOMMENDED = "multi-criteria"
"""The selector to start with where no other is asked for."""

BUILT_IN: dict[str, type] = {
    "random": Random,
    "quantile": Quantile,
    "quantile-local": QuantileLocal,
    "nearest": Nearest,
    "nearest-euclidean": NearestEuclidean,
    "utility": Utility,
    "information-gain": InformationGain,
    "minpos": MinPos,
    "hungarian": Hungarian,
    "voronoi": Voronoi,
    "potential": Potential,
    "llm-like": LlmLike,
    "multi-criteria": MultiCriteria,
}

WITH_MODELS: dict[str, type] = {
    "llm": Llm,
    "llm-shortlist": LlmShortlist,
    "shortlist-random": ShortlistRandom,
}
"""Selectors that ask a language model, and their control; docs/llm.md has what they are worth."""

SELECTORS: Registry[Selector] = Registry(
    noun="selector",
    method="choose(view, memory)",
    face=Selector,  # type: ignore[type-abstract]
    error=SelectorError,
    group="swarmscout.selectors",
    built_in=BUILT_IN | WITH_MODELS,
)


def selectors() -> dict[str, str]:
    """Names of all rules that can be used by name, each with one line on what it does.

    :func:`model_selectors` has those that ask a language model.
    """
    return {name: line for name, line in SELECTORS.names().items() if name not in WITH_MODELS}


def model_selectors() -> dict[str, str]:
    """Names of the selectors that ask a language model and of their control, each with one line."""
    return {name: (kind.__doc__ or "").splitlines()[0] for name, kind in WITH_MODELS.items()}


def make_selector(
    name: str, parameters: Mapping[str, Any] | None = None, base: Path | None = None
) -> Selector:
    """Make the selector behind a name; a file is run for that.

    Args:
        name: a name of :func:`selectors`, or ``file.py:ClassName``.
        parameters: keyword arguments for its class.
        base: the folder that a relative file is looked for in, besides the working directory.

    Raises:
        SelectorError: there is no such selector, or it does not take these parameters.
    """
    return SELECTORS.make(name, parameters, base)
