"""Functions that run one mission and return its recording."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from swarmscout.core.errors import RunError, WorldError
from swarmscout.core.language_model import Model
from swarmscout.core.recorder import Recorder, StepRecord
from swarmscout.core.registry import Registry
from swarmscout.destinations.registry import RECOMMENDED, SELECTORS
from swarmscout.destinations.selector import Selector
from swarmscout.mission.mission import Mission
from swarmscout.mission.scenario import Scenario
from swarmscout.mission.scenario_files import make_scenario
from swarmscout.recording.run import Run
from swarmscout.recording.run_folder import as_path, claim_folder, release_folder
from swarmscout.recording.tables import check_level
from swarmscout.recording.writer import RunWriter
from swarmscout.teams.policy import DesiredSizePolicy
from swarmscout.teams.registry import POLICIES
from swarmscout.worlds.arrays import world_from_array
from swarmscout.worlds.world import World

__all__ = ["explore", "record_mission"]


R = TypeVar("R")

_DEFAULT = Scenario()


def explore(
    world: str | Path | World | NDArray[np.bool_] = _DEFAULT.world,
    robots: int = _DEFAULT.robots,
    steps: int = _DEFAULT.steps,
    destinations: str | Selector | type[Selector] = RECOMMENDED,
    seed: int = _DEFAULT.seed,
    *,
    out: str | Path | None = None,
    record: str = "full",
    model: Model | None = None,
    links: Callable[[int], Any] | None = None,
    **more: Any,
) -> Run:
    """Run a mission to its end.

    Args:
        world: a named world, the path of a map, a :class:`~swarmscout.worlds.world.World`, or an
            array bool[rows, cols]: true where a robot may be, row 0 at the lowest y, cells of
            0.1 m.
        robots: N, the number of robots.
        steps: the mission's length.
        destinations: a selector's name (by default the recommended one; the paper's is
            ``quantile``), ``FILE.py:NAME``, or a selector: its class or an object. An object is not
            kept, so ``swarmscout explore RUN`` refuses the run.
        seed: starts, noise, charge, characters, decisions.
        out: a new or empty folder for the run; None keeps it in memory.
        record: ``full``; ``curves`` (no steps, maps or events); ``summary``.
        model: the language model for selectors that use one, instead of the scenario's. It is not
            kept, so ``swarmscout explore RUN`` needs ``--llm``.
        links: who hears whom, a function from the step to bool[N, N]; then each robot keeps a map
            of its own. It is not kept, so ``swarmscout explore RUN`` refuses the run.
        **more: further scenario keys; a section is a mapping: ``teams={"desired_size": 3}``, in
            which ``policy`` may be a policy's class or an object too.

    Returns:
        The finished run.

    Raises:
        ScenarioError: a key is unknown or impossible.
        WorldError: the world cannot be loaded.
        SelectorError: the selector is unknown.
        PolicyError: the policy is unknown.
        ModelError: the selector asks a language model, and none is configured.
        RunError: ``out`` is not empty or cannot be written.

    Example:
        >>> run = explore(robots=5, steps=50, seed=1)  # doctest: +SKIP
        >>> run.summary["explored_m2"]  # doctest: +SKIP
    """
    given = world_from_array(world) if isinstance(world, np.ndarray) else world
    rule = _handed_over(SELECTORS, "destinations", destinations, more)
    sizes = None
    teams = more.get("teams")
    if isinstance(teams, Mapping) and "policy" in teams:
        sizes = _handed_over(POLICIES, "key 'teams.policy'", teams["policy"], more)
        if sizes is not None:
            more["teams"] = {key: value for key, value in teams.items() if key != "policy"}
    keys: dict[str, Any] = {
        "world": given.name if isinstance(given, World) else _text("world", given),
        "robots": robots,
        "steps": steps,
        "destinations": destinations if rule is None else _DEFAULT.destinations,
        "seed": seed,
        **more,
    }
    if isinstance(keys.get("battery", {}), Mapping):
        # As `swarmscout explore`: robots return in time, unless a key says otherwise.
        keys["battery"] = {"return_rule": "distance", **keys.get("battery", {})}
    scenario = make_scenario(keys)
    at_hand = given if isinstance(given, World) else None
    return record_mission(
        scenario, out=out, record=record, world=at_hand, selector=rule, policy=sizes, model=model,
        links=links,
    )  # fmt: skip


def _text(name: str, given: object) -> str:
    if not isinstance(given, str | Path):
        raise WorldError(
            f"{name} is a {type(given).__name__}, expected a world's name, the path of a map, a "
            "World or an array of booleans"
        )
    return str(given)


def _handed_over(kind: Registry[R], key: str, given: object, more: dict[str, Any]) -> R | None:
    """The rule given as a class or an object; None if it was given by name."""
    if isinstance(given, str):
        return None
    if isinstance(given, type):
        parameters = more.pop(kind.noun, {})
        return kind.make_object(given, given.__name__, parameters)
    if more.get(kind.noun):
        raise kind.error(
            f"{kind.noun} parameters belong to a {kind.noun}'s name or class; this one is "
            "already made"
        )
    if not isinstance(given, kind.face):
        raise kind.error(
            f"{key} is a {type(given).__name__}, expected a {kind.noun}'s name, "
            f"'FILE.py:NAME', or an object with a method {kind.method}"
        )
    return given


def record_mission(
    scenario: Scenario,
    *,
    out: str | Path | None = None,
    record: str = "full",
    world: World | None = None,
    base: Path | None = None,
    selector: Selector | None = None,
    policy: DesiredSizePolicy | None = None,
    on_step: Callable[[Mission], None] | None = None,
    model: Model | None = None,
    links: Callable[[int], Any] | None = None,
    watchers: Sequence[Recorder] = (),
) -> Run:
    """Run a scenario's mission and record it.

    When an error or an interrupt ends the mission early, the steps recorded until then are written
    before the exception is passed on. A mission that never began leaves nothing behind.

    Args:
        scenario: what to run.
        out: a new or empty folder, or None for memory.
        record: the recording level.
        world: the world, instead of the one that the scenario names.
        base: folder for relative paths of the scenario, besides the working directory.
        selector: the selector, instead of the one that the scenario names.
        policy: the policy for desired team sizes, likewise.
        on_step: called with the mission after each step.
        model: the language model for selectors that use one, instead of the scenario's.
        links: who hears whom, a function from the step to bool[N, N]; then each robot keeps a map
            of its own.
        watchers: further recorders, for example one that shows the mission while it runs.

    Raises:
        SwarmscoutError: as :func:`explore`.
    """
    check_level(record)
    folder = None if out is None else claim_folder(as_path(out))
    writer = RunWriter(folder, level=record, whole_world=world is not None)
    mission: Mission | None = None
    try:
        recorder = _All([writer, *watchers]) if watchers else writer
        mission = Mission(
            scenario, world=world, recorder=recorder, base=base, selector=selector, policy=policy,
            model=model, links=links,
        )  # fmt: skip
        mission.run(on_step)
    except BaseException:
        # The first error matters; a full disk may be that error.
        with contextlib.suppress(RunError):
            writer.close()
        if folder is not None:
            release_folder(folder)
        raise
    finally:
        if mission is not None:
            mission.close()
    return writer.run()


class _All:
    """Several recorders as one; the writer comes first, so steps are recorded before shown."""

    def __init__(self, recorders: Sequence[Recorder]) -> None:
        self._recorders = recorders

    def begin(self, mission: Mission) -> None:
        for recorder in self._recorders:
            recorder.begin(mission)

    def record(self, record: StepRecord) -> None:
        for recorder in self._recorders:
            recorder.record(record)

    def end(self, summary: Mapping[str, Any]) -> None:
        for recorder in self._recorders:
            recorder.end(summary)
