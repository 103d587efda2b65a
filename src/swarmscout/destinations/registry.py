"""Selectors by name: those of the package, of other packages, and of a user's own file.

Other packages register theirs under the entry point group ``swarmscout.selectors``. A class in a
file is named ``path/to/file.py:ClassName``.
"""

from __future__ import annotations

import importlib.util
import inspect
import sys
from collections.abc import Mapping
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any

from swarmscout.core.errors import SelectorError, did_you_mean
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

__all__ = ["RECOMMENDED", "make_selector", "model_selectors", "selectors"]

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


def _plugins() -> dict[str, EntryPoint]:
    found = entry_points(group="swarmscout.selectors")
    return {point.name: point for point in found if point.name not in BUILT_IN | WITH_MODELS}


def selectors() -> dict[str, str]:
    """Names of all rules that can be used by name, each with one line on what it does.

    :func:`model_selectors` has those that ask a language model.
    """
    lines = {name: (kind.__doc__ or "").splitlines()[0] for name, kind in BUILT_IN.items()}
    for name, point in _plugins().items():
        lines[name] = f"from {point.dist.name if point.dist else point.value}"
    return lines


def model_selectors() -> dict[str, str]:
    """Names of the selectors that ask a language model and of their control, each with one line."""
    return {name: (kind.__doc__ or "").splitlines()[0] for name, kind in WITH_MODELS.items()}


def make_selector(
    name: str, parameters: Mapping[str, Any] | None = None, base: Path | None = None
) -> Selector:
    """Make the selector behind a name.

    Args:
        name: a name of :func:`selectors`, or ``file.py:ClassName``.
        parameters: keyword arguments for its class.
        base: the folder that a relative file is looked for in, besides the working directory.

    Raises:
        SelectorError: there is no such selector, or it does not take these parameters.
    """
    kind = _kind(name, base)
    given = dict(parameters or {})
    if not callable(kind):
        raise SelectorError(f"'{name}' is no selector: it is {kind!r}, not a class")
    try:
        accepted = list(inspect.signature(kind).parameters)
    except (TypeError, ValueError):
        accepted = list(given)
    for key in given:
        if key not in accepted:
            raise SelectorError(
                f"selector '{name}' has no parameter '{key}': "
                f"{did_you_mean(key, accepted) if accepted else 'it takes none'}"
            )
    try:
        selector = kind(**given)
    except (TypeError, ValueError) as error:
        raise SelectorError(f"selector '{name}': {error}") from None
    if not isinstance(selector, Selector):
        raise SelectorError(f"'{name}' is no selector: it has no method choose(view, memory)")
    return selector


def _kind(name: str, base: Path | None) -> Any:
    if name in BUILT_IN:
        return BUILT_IN[name]
    if name in WITH_MODELS:
        return WITH_MODELS[name]
    path, colon, attribute = name.rpartition(":")
    if colon and path.endswith(".py"):
        return _from_file(Path(path), attribute, base)
    if name.endswith(".py"):
        raise SelectorError(f"'{name}' names a file but no class in it: write '{name}:ClassName'")
    plugins = _plugins()
    if name not in plugins:
        known = [*BUILT_IN, *WITH_MODELS, *plugins]
        raise SelectorError(f"unknown selector '{name}': {did_you_mean(name, known)}")
    try:
        return plugins[name].load()
    except Exception as error:
        raise SelectorError(
            f"selector '{name}' ({plugins[name].value}) cannot be loaded: "
            f"{type(error).__name__}: {error}"
        ) from error


def _from_file(path: Path, attribute: str, base: Path | None) -> Any:
    candidates = [path] if base is None or path.is_absolute() else [base / path, path]
    found = next((candidate for candidate in candidates if candidate.is_file()), None)
    if found is None:
        raise SelectorError(f"selector file '{path}' does not exist")
    # A name of its own, so that two files called my.py do not replace each other; dataclasses
    # look their module up by name.
    module_name = f"swarmscout_user_{abs(hash(str(found.resolve())))}"
    spec = importlib.util.spec_from_file_location(module_name, found)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[module_name] = module
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        del sys.modules[module_name]
        line = getattr(error, "lineno", None)
        raise SelectorError(
            f"selector file '{path}' cannot be loaded: {type(error).__name__}: {error}"
            + (f" (line {line})" if line and "line" not in str(error) else "")
        ) from error
    if not hasattr(module, attribute):
        classes = [n for n, v in vars(module).items() if inspect.isclass(v)]
        raise SelectorError(
            f"selector file '{path}' has no '{attribute}': {did_you_mean(attribute, classes)}"
        )
    return getattr(module, attribute)
