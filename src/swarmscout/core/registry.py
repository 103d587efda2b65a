"""Plug-ins of one kind: those of the package, of other packages, and of a user's own file.

A *kind* of plug-in (selectors, policies, …) has a noun, an error and a protocol. A plug-in is named
by its registered name or as ``path/to/file.py:ClassName``. Other packages register theirs under the
kind's entry point group. The package's own classes are imported when they are used, so a registry
may name classes that import it.
"""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import reprlib
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from hashlib import blake2b
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any, Generic, TypeVar

from pydantic import ValidationError

from swarmscout.core.errors import SwarmscoutError, did_you_mean
from swarmscout.core.parameters import check_arguments, describe_invalid_arguments
from swarmscout.core.paths import expanded
from swarmscout.core.tracebacks import describe_error

__all__ = ["IN_MEMORY", "Registry", "rule_name"]

IN_MEMORY = "object:"
"""Prefix of the name that a scenario gives to a plug-in that was passed as an object."""

R = TypeVar("R")


@dataclass(frozen=True)
class Registry(Generic[R]):
    """All plug-ins of one kind.

    Attributes:
        noun: what one is called: "selector".
        method: its method, as an author writes it: "choose(view, memory)".
        face: the protocol that a plug-in has to meet; checked at run time.
        error: raised for everything that is wrong with one.
        group: of entry points, where other packages register theirs.
        built_in: where the package's own are, by name, as "module:Class".
    """

    noun: str
    method: str
    face: type[R]
    error: type[SwarmscoutError]
    group: str
    built_in: Mapping[str, str]

    def names(self) -> dict[str, str]:
        """All registered names, each with the first line of its docstring.

        Every class is imported for this. One that cannot be imported is listed with the reason.
        """
        lines = {name: _first_line(self.load(name)) for name in self.built_in}
        for name, point in self._plugins().items():
            origin = f"from {point.dist.name if point.dist else point.value}"
            try:
                line = _first_line(self.load(name))
            except self.error as error:
                lines[name] = str(error)
            else:
                lines[name] = f"{line} ({origin})" if line else origin
        return lines

    def make(
        self, name: str, parameters: Mapping[str, Any] | None = None, base: Path | None = None
    ) -> R:
        """Make the plug-in of a name; if the name is a file's, its code is run.

        Args:
            name: one of :meth:`names`, or ``file.py:ClassName``.
            parameters: keyword arguments for its class.
            base: the folder that a relative file is looked for in, besides the working directory.

        Raises:
            SwarmscoutError: the kind's own error: there is no such plug-in, or it does not take
                these parameters.
        """
        return self.make_object(self.load(name, base), name, parameters or {})

    def load(self, name: str, base: Path | None = None) -> Callable[..., Any]:
        """The class of a name, or a function that makes one.

        Args:
            name: as for :meth:`make`.
            base: as there.

        Raises:
            SwarmscoutError: the kind's own error: there is no such plug-in.
        """
        kind = self._kind(name, base)
        if not callable(kind):
            raise self.error(
                f"'{name}' is not a {self.noun}: it is {reprlib.repr(kind)}, not a class"
            )
        return kind  # type: ignore[no-any-return]

    def make_object(self, kind: Callable[..., Any], name: str, parameters: Mapping[str, Any]) -> R:
        """Make a plug-in of its class.

        Args:
            kind: the class, or a function that makes one.
            name: what it is called in errors.
            parameters: keyword arguments.

        Raises:
            SwarmscoutError: the kind's own error: it does not take these, or lacks the method.
        """
        subject = f"{self.noun} '{name}'"
        check_arguments(subject, kind, parameters, self.error)
        try:
            made = kind(**parameters)
        except ValidationError as error:
            raise self.error(f"{subject}: {describe_invalid_arguments(error)}") from None
        except ValueError as error:  # Its author's own words on an impossible value.
            raise self.error(f"{subject}: {error}") from None
        except (Exception, SystemExit) as error:
            raise self.error(f"{subject} cannot be made: {describe_error(error)}") from error
        if not isinstance(made, self.face):
            lacking = self._incomplete(made) or f"it has no method {self.method}"
            raise self.error(f"'{name}' is not a {self.noun}: {lacking}")
        return made

    def check_object(self, rule: object) -> R:
        """A plug-in that was passed as an object, if it is one.

        Raises:
            SwarmscoutError: the kind's own error: it is something else, perhaps a class.
        """
        if isinstance(rule, type) or not isinstance(rule, self.face):
            what = f"the class {rule.__name__}" if isinstance(rule, type) else _a(rule)
            wanted = "" if isinstance(rule, type) else self._incomplete(rule)
            wanted = wanted or f"expected an object with a method {self.method}"
            raise self.error(f"{self.noun} is {what}, {wanted}")
        return rule

    def file(self, name: str, base: Path | None = None) -> Path | None:
        """The file that a name leads to, or None for a registered name.

        Args:
            name: as for :meth:`make`.
            base: as there.

        Raises:
            SwarmscoutError: the kind's own error: there is no such file.
        """
        text, colon, _ = name.rpartition(":")
        if not (colon and text.endswith(".py")):
            return None
        path = expanded(text)
        candidates = [path] if base is None or path.is_absolute() else [base / path, path]
        found = next((candidate for candidate in candidates if candidate.is_file()), None)
        if found is None:
            raise self.error(f"{self.noun} file '{text}' does not exist")
        return found

    def _incomplete(self, rule: object) -> str:
        """How to complete an object that has the method, but not all of the protocol."""
        if not callable(getattr(rule, self.method.partition("(")[0], None)):
            return ""
        return f"derive its class from {self.face.__module__}.{self.face.__name__}"

    def _plugins(self) -> dict[str, EntryPoint]:
        found = entry_points(group=self.group)
        return {point.name: point for point in found if point.name not in self.built_in}

    def _kind(self, name: str, base: Path | None) -> Any:
        if name in self.built_in:
            module, _, attribute = self.built_in[name].partition(":")
            return getattr(importlib.import_module(module), attribute)
        if name.startswith(IN_MEMORY):
            raise self.error(
                f"{self.noun} '{name}' was an object in memory: put its class into a file and name "
                f"it FILE.py:{name.removeprefix(IN_MEMORY)}"
            )
        found = self.file(name, base)
        if found is not None:
            return self._from_file(found, name.rpartition(":")[2])
        if name.endswith(".py"):
            raise self.error(f"'{name}' names a file but no class in it: write '{name}:ClassName'")
        plugins = self._plugins()
        if name not in plugins:
            known = [*self.built_in, *plugins]
            raise self.error(f"unknown {self.noun} '{name}': {did_you_mean(name, known)}")
        try:
            return plugins[name].load()
        except (Exception, SystemExit) as error:
            raise self.error(
                f"{self.noun} '{name}' ({plugins[name].value}) cannot be loaded: "
                f"{describe_error(error)}"
            ) from error

    def _from_file(self, path: Path, attribute: str) -> Any:
        # A name of its own, so that two files called my.py do not replace each other; dataclasses
        # look their module up by name.
        digest = blake2b(str(path.resolve()).encode(), digest_size=8).hexdigest()
        # The same in every process: Numba looks a cached kernel's module up by its name.
        module_name = f"swarmscout_user_{digest}"
        spec = importlib.util.spec_from_file_location(module_name, path)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        sys.modules[module_name] = module
        try:
            spec.loader.exec_module(module)
        except (Exception, SystemExit) as error:
            del sys.modules[module_name]
            raise self.error(
                f"{self.noun} file '{path}' cannot be loaded: {describe_error(error)}"
            ) from error
        if not hasattr(module, attribute):
            classes = [n for n, v in vars(module).items() if inspect.isclass(v)]
            raise self.error(
                f"{self.noun} file '{path}' has no '{attribute}': "
                f"{did_you_mean(attribute, classes)}"
            )
        return getattr(module, attribute)


def rule_name(name: str) -> str:
    """What records call a plug-in: a file is called by its own name, without its folder.

    Args:
        name: as a scenario names it.
    """
    file, colon, kind = name.rpartition(":")
    return f"{Path(file).name}{colon}{kind}" if file.endswith(".py") else name


def _first_line(kind: Callable[..., Any]) -> str:
    return next(iter((inspect.getdoc(kind) or "").splitlines()), "")


def _a(thing: object) -> str:
    return f"a {type(thing).__name__}"
