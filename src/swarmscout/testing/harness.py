"""The conformance harness: asks a plug-in several times, and watches what it reads and changes.

A check of one kind of plug-in is a :class:`Guard` with the kind's registry, its views and its
rules for answers; see :mod:`swarmscout.testing.check_selector` for one.
"""

from __future__ import annotations

import inspect
from abc import ABC, abstractmethod
from collections.abc import Callable, Container, Iterable
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any, ClassVar, Generic, Self, TypeVar

from swarmscout.core.errors import SwarmscoutError
from swarmscout.core.registry import Registry
from swarmscout.core.tracebacks import describe_error
from swarmscout.mission.mission import Mission
from swarmscout.testing.fingerprints import (
    drawn_from,
    fingerprint,
    global_states,
    held_by,
    seeded_globals,
    shifted_clocks,
    writes_read_only,
)

__all__ = ["Guard", "PlugInCheck", "Report", "instance_of", "note_private_read", "outcome"]

V = TypeVar("V")

_COUNTS = {1: "one argument", 2: "two arguments", 3: "three arguments"}
_LATER_S = 86_461.7


@dataclass(frozen=True, slots=True)
class Report:
    """What was checked and found sound.

    Attributes:
        noun: what kind of plug-in was checked: "selector".
        name: the plug-in's.
        checks: one line for each part of the contract.
        situations: descriptions of the situations that it was tried in.
        answers: number of questions asked.
    """

    noun: str
    name: str
    checks: tuple[str, ...]
    situations: tuple[str, ...]
    answers: int

    def __str__(self) -> str:
        """The report as text, one line for each check and each situation."""
        lines = [f"{self.noun} '{self.name}' is sound ({self.answers} answers):"]
        lines += [f"  {check}" for check in self.checks]
        lines += ["tried with:", *(f"  {words}" for words in self.situations)]
        return "\n".join(lines)


class PlugInCheck:
    """A plug-in under a check.

    Attributes:
        registry: the kind's registry.
        checks: the parts of the contract, one line each.
        rule: the plug-in that is checked.
        name: its name in errors.
        where: the situation in words, or "" in a mission.
        answers: number of questions asked so far.

    Args:
        given: an instance, a class that needs no arguments, a registered name, or
            ``path/to/file.py:ClassName``.
    """

    registry: ClassVar[Registry[Any]]
    checks: ClassVar[tuple[str, ...]]
    _flown: ClassVar[str] = "each twice"

    def __init__(self, given: Any) -> None:
        self.rule, self.name = instance_of(self.registry, given)
        self.where = ""
        self.answers = 0

    def fly(self, make: Callable[[Self, int], Mission], missions: int, seed: int) -> list[str]:
        """Run missions in small caves to their ends, each twice.

        Args:
            make: makes a mission in which the plug-in, or a guard, is used.
            missions: number of missions.
            seed: of the first one.

        Returns:
            A description of what was run.

        Raises:
            SwarmscoutError: the kind's own error: something is wrong in a mission.
        """
        self.where = ""
        for k in range(seed, seed + missions):
            if self._differs(make, k):
                raise self._error(
                    f"{self._subject} is not deterministic: the same mission in small_world({k}) "
                    "went differently when it was run again"
                )
        return [f"{missions} missions in small caves, {self._flown}"] if missions else []

    def report(self, situations: Iterable[str]) -> Report:
        """The report on what was checked."""
        noun = self.registry.noun
        return Report(noun, self.name, self.checks, tuple(situations), self.answers)

    def _differs(self, make: Callable[[Self, int], Mission], seed: int) -> bool:
        """Whether two equal missions differ."""
        return outcome(make(self, seed)) != outcome(make(self, seed))

    @property
    def _subject(self) -> str:
        return f"{self.registry.noun} '{self.name}'"

    def _error(self, message: str) -> SwarmscoutError:
        return self.registry.error(message)


class Guard(PlugInCheck, ABC, Generic[V]):
    """A plug-in that asks another one in its place, and checks each answer.

    A subclass adds the kind's own method, which calls :meth:`answer`, and defines the views and
    answers of the kind. A view is everything that is shown in one call, with its ``step``.

    Attributes:
        draw_from: advice for plug-ins that draw from global generators.
        remember_in: advice for plug-ins that change themselves.
        spread: in missions, repeat the question in every ``spread``-th step only.
    """

    draw_from: ClassVar[str]
    remember_in: ClassVar[str]
    spread: ClassVar[int] = 1
    _flown = "to the end, each twice"

    def __init__(self, given: Any) -> None:
        super().__init__(given)
        self._watching = True

    @abstractmethod
    def ask(self, view: V, memory: Any) -> Any:
        """The plug-in's answer to a view."""

    @abstractmethod
    def watched(self, view: V) -> V:
        """A fresh view that is equal to the one given and notes reads of private attributes."""

    @abstractmethod
    def look(self, view: V) -> list[Any]:
        """Fingerprints of everything in a view that the plug-in may not change."""

    @abstractmethod
    def checked(self, answer: Any, view: V) -> Any:
        """The answer, if it is a proper one.

        Raises:
            SwarmscoutError: the kind's own error; the message starts with a verb.
        """

    def spoilt(self, view: V, shown: V) -> bool:
        """Whether the view that was shown differs from the one that it was made of."""
        return False

    def answer(self, view: V, memory: Any = None, *, once: bool = False) -> Any:
        """The plug-in's answer, if it keeps to the contract.

        Args:
            view: what is shown.
            memory: what the plug-in remembered.
            once: whether not to repeat the question.

        Raises:
            SwarmscoutError: the kind's own error, with the part of the contract that is broken.
        """
        self.answers += 1
        if not self._watching:
            return self.ask(view, memory)
        step: int = view.step  # type: ignore[attr-defined]
        once = once or (not self.where and self.spread > 1 and step % self.spread != 1)
        try:
            return self._answered(view, memory, once)
        except self.registry.error as error:
            where = self.where or f"in step {step} of a mission"
            raise self._error(f"{self._subject} {error} ({where})") from error.__cause__

    def _differs(self, make: Callable[[Self, int], Mission], seed: int) -> bool:
        """Run one mission with watching and one without."""
        results = []
        for self._watching in (True, False):
            results.append(self._run(make(self, seed)))
        return results[0] != results[1]

    def _run(self, mission: Mission) -> tuple[Any, ...]:
        try:
            return outcome(mission)
        except self.registry.error as error:
            # A mission wraps what a guard raises into its own words.
            if isinstance(error.__cause__, self.registry.error):
                raise error.__cause__ from error.__cause__.__cause__
            raise

    def _answered(self, view: V, memory: Any, once: bool) -> Any:
        first = self._watch(view, memory)
        if once:
            return first
        expected = fingerprint(first)

        def differs(**changes: Any) -> bool:
            return bool(fingerprint(self._watch(view, memory, **changes)) != expected)

        clock = "depends on the clock: use view.step"
        randomness = (
            "depends on global randomness: its answer changes with the seed of random or "
            f"numpy.random; {self.draw_from}"
        )
        changes: dict[str, dict[str, Any]] = {
            "": {}, clock: {"later_s": _LATER_S}, randomness: {"globals_seed": 2},
        }  # fmt: skip
        for blame, change in changes.items():
            if differs(**change):
                # The change is to blame only if the answer stays the same without it.
                if blame and not differs():
                    raise self._error(blame)
                raise self._error(
                    "is not deterministic: it gave two different answers to the same view; "
                    f"{self.remember_in}"
                )
        return first

    def _watch(self, view: V, memory: Any, *, globals_seed: int = 1, later_s: float = 0.0) -> Any:
        """Ask once; the global generators and the clocks are put back afterwards."""
        shown = self.watched(view)
        seen, handed, itself = self.look(view), fingerprint(memory), held_by(self.rule)
        with seeded_globals(globals_seed), shifted_clocks(later_s):
            before = global_states()
            try:
                answer = self.ask(shown, memory)
            except Exception as error:
                if _is_change_of_view(error):
                    raise self._error(
                        f"tries to change its view, which is read-only ({error}); work on a copy"
                    ) from error
                raise self._error(f"failed: {describe_error(error)}") from error
            drawn = drawn_from(before)
        private = vars(shown).get("private_reads")
        if private:
            raise self._error(
                f"reads '{private[0]}' of its view, which is private: only what is public in a "
                "view can be used"
            )
        if drawn:
            raise self._error(f"draws from the global generator of {drawn[0]}; {self.draw_from}")
        if self.look(view) != seen or self.spoilt(view, shown):
            raise self._error("changed its view, which is read-only; work on a copy")
        if fingerprint(memory) != handed:
            raise self._error(f"changed the memory that it was handed; {self.remember_in}")
        changed = sorted(n for n, value in held_by(self.rule).items() if itself.get(n) != value)
        if changed:
            raise self._error(
                f"changed itself (attribute '{changed[0]}'): one {self.registry.noun} serves all "
                f"robots; {self.remember_in}"
            )
        return self.checked(answer, view)


def outcome(mission: Mission) -> tuple[Any, ...]:
    """Run a mission to its end; what two equal missions have in common."""
    mission.run()
    return (
        mission.step_number,
        mission.end_reason,
        mission.explored_m2,
        mission.bodies.pose.tobytes(),
        mission.minds.own.tobytes(),
    )


def note_private_read(view: object, name: str, caller: FrameType, own: Container[object]) -> bool:
    """Note it in a view's ``private_reads`` if a plug-in reads a private attribute of the view.

    Args:
        view: of a class that calls this in its ``__getattribute__``.
        name: of the attribute.
        caller: where it is read.
        own: names of the modules that may read it.

    Returns:
        Whether the caller is foreign, for a private or a public attribute.
    """
    foreign = caller.f_globals.get("__name__") not in own
    private = name.startswith("_") and (name == "__dict__" or not name.startswith("__"))
    if foreign and private:
        object.__getattribute__(view, "__dict__").setdefault("private_reads", []).append(name)
    return foreign


def instance_of(kind: Registry[Any], given: Any) -> tuple[Any, str]:
    """The plug-in that is to be checked, and its name.

    Raises:
        SwarmscoutError: the kind's own error: there is no such plug-in, or it cannot be asked.
    """
    given = str(given) if isinstance(given, Path) else given
    if isinstance(given, str):
        rule, name = kind.make(given), given
    elif inspect.isclass(given):
        name = given.__name__
        try:
            rule = given()
        except TypeError as error:
            raise kind.error(
                f"{kind.noun} '{name}' cannot be made without arguments ({error}): give an instance"
            ) from None
    else:
        rule, name = given, type(given).__name__
    asked, _, arguments = kind.method.rstrip(")").partition("(")
    names = arguments.split(", ")
    method = getattr(rule, asked, None)
    if not callable(method):
        raise kind.error(f"'{name}' is not a {kind.noun}: it has no method {kind.method}")
    try:
        inspect.signature(method).bind(*names)
    except TypeError:
        raise kind.error(
            f"{kind.noun} '{name}' cannot be asked: its {asked}{inspect.signature(method)} does "
            f"not take {_COUNTS[len(names)]}, {kind.method}"
        ) from None
    return rule, name


def _is_change_of_view(error: Exception) -> bool:
    # A frozen dataclass, and a property that cannot be set.
    frozen = isinstance(error, AttributeError) and (
        "cannot assign to field" in str(error) or "no setter" in str(error)
    )
    return frozen or writes_read_only(error)
