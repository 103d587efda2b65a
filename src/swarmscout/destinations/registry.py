"""Selectors by name: those of the package, of other packages, and of a user's own file.

Other packages register theirs under the entry point group ``swarmscout.selectors``. A class in a
file is named ``path/to/file.py:ClassName``.
"""

from __future__ import annotations

import importlib.util
import inspect
import reprlib
import sys
from collections.abc import Callable, Mapping
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any

from swarmscout.core.blame import told
from swarmscout.core.errors import SelectorError, did_you_mean
from swarmscout.destinations.hungarian import Hungarian
from swarmscout.destinations.information_gain import InformationGain
from swarmscout.destinations.llm_like import LlmLike
from swarmscout.destinations.minpos import MinPos
from swarmscout.destinations.multi_criteria import MultiCriteria
from swarmscout.destinations.nearest import Nearest
from swarmscout.destinations.nearest_euclidean import NearestEuclidean
from swarmscout.destinations.parameters import check_parameters
from swarmscout.destinations.potential import Potential
from swarmscout.destinations.quantile import Quantile
from swarmscout.destinations.quantile_local import QuantileLocal
from swarmscout.destinations.random import Random
from swarmscout.destinations.selector import Selector
from swarmscout.destinations.utility import Utility
from swarmscout.destinations.voronoi import Voronoi

__all__ = [
    "IN_MEMORY",
    "RECOMMENDED",
    "make_object",
    "make_selector",
    "selector_file",
    "selectors",
]

IN_MEMORY = "object:"
"""A scenario names a selector that was handed over as an object by this and its class."""

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


def _plugins() -> dict[str, EntryPoint]:
    found = entry_points(group="swarmscout.selectors")
    return {point.name: point for point in found if point.name not in BUILT_IN}


def selectors() -> dict[str, str]:
    """Names of all selectors that can be used by name, each with one line on what it does."""
    lines = {name: (kind.__doc__ or "").splitlines()[0] for name, kind in BUILT_IN.items()}
    for name, point in _plugins().items():
        lines[name] = f"from {point.dist.name if point.dist else point.value}"
    return lines


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
    kind = _kind(name, base)
    if not callable(kind):
        raise SelectorError(f"'{name}' is no selector: it is {reprlib.repr(kind)}, not a class")
    return make_object(kind, name, parameters or {})


def make_object(kind: Callable[..., Any], name: str, parameters: Mapping[str, Any]) -> Selector:
    """Make a selector of its class.

    Args:
        kind: the class, or a function that makes one.
        name: what it is called in errors.
        parameters: keyword arguments.

    Raises:
        SelectorError: it does not take these parameters, or is no selector.
    """
    check_parameters(name, kind, parameters, lengths=name in BUILT_IN)
    try:
        selector = kind(**parameters)
    except (Exception, SystemExit) as error:
        if isinstance(error, ValueError):  # Its author's own words on an impossible value.
            raise SelectorError(f"selector '{name}': {error}") from None
        raise SelectorError(f"selector '{name}' cannot be made: {told(error)}") from error
    if not isinstance(selector, Selector):
        raise SelectorError(f"'{name}' is no selector: it has no method choose(view, memory)")
    return selector


def _kind(name: str, base: Path | None) -> Any:
    if name in BUILT_IN:
        return BUILT_IN[name]
    if name.startswith(IN_MEMORY):
        raise SelectorError(
            f"selector '{name}' was an object in memory: put its class into a file and name it "
            f"FILE.py:{name.removeprefix(IN_MEMORY)}"
        )
    found = selector_file(name, base)
    if found is not None:
        return _from_file(found, name.rpartition(":")[2])
    if name.endswith(".py"):
        raise SelectorError(f"'{name}' names a file but no class in it: write '{name}:ClassName'")
    plugins = _plugins()
    if name not in plugins:
        known = [*BUILT_IN, *plugins]
        raise SelectorError(f"unknown selector '{name}': {did_you_mean(name, known)}")
    try:
        return plugins[name].load()
    except (Exception, SystemExit) as error:
        raise SelectorError(
            f"selector '{name}' ({plugins[name].value}) cannot be loaded: {told(error)}"
        ) from error


def selector_file(name: str, base: Path | None = None) -> Path | None:
    """The file that a selector's name leads to, or None where it names no file.

    Args:
        name: as for :func:`make_selector`.
        base: as there.

    Raises:
        SelectorError: there is no such file.
    """
    text, colon, _ = name.rpartition(":")
    if not (colon and text.endswith(".py")):
        return None
    path = Path(text).expanduser()
    candidates = [path] if base is None or path.is_absolute() else [base / path, path]
    found = next((candidate for candidate in candidates if candidate.is_file()), None)
    if found is None:
        raise SelectorError(f"selector file '{text}' does not exist")
    return found


def _from_file(path: Path, attribute: str) -> Any:
    # A name of its own, so that two files called my.py do not replace each other; dataclasses
    # look their module up by name.
    module_name = f"swarmscout_user_{abs(hash(str(path.resolve())))}"
    spec = importlib.util.spec_from_file_location(module_name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[module_name] = module
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        del sys.modules[module_name]
        raise SelectorError(f"selector file '{path}' cannot be loaded: {told(error)}") from error
    if not hasattr(module, attribute):
        classes = [n for n, v in vars(module).items() if inspect.isclass(v)]
        raise SelectorError(
            f"selector file '{path}' has no '{attribute}': {did_you_mean(attribute, classes)}"
        )
    return getattr(module, attribute)
