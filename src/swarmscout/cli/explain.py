"""``swarmscout explain``: one decision in full."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from swarmscout.core.text import clean_line, clean_text

if TYPE_CHECKING:
    from swarmscout.recording.run import Run

__all__ = ["explain"]


def explain(
    run: Annotated[Path, Parameter(metavar="RUN")],
    /,
    *,
    step: int | None = None,
    team: int | None = None,
    leader: int | None = None,
    prompts: bool = True,
) -> int:
    """Show a decision in full: its leader, cause, prompts, answers, verdicts and choice.

    Without --step, list all decisions.

    Args:
        run: a run's folder.
        step: the step in which it was made.
        team: the team that it was made for.
        leader: the robot that made it.
        prompts: show prompts and answers in full.
    """
    from swarmscout.core.errors import RunError
    from swarmscout.recording.run import Run

    opened = Run.open(run)
    rows = opened.decisions.to_dicts()
    if not rows:
        raise RunError(f"run '{run}' has no decisions")
    wanted = {"step": step, "team": team, "leader": leader}
    keys = {key: value for key, value in wanted.items() if value is not None}
    found = [row for row in rows if all(row[key] == value for key, value in keys.items())]
    if not found:
        raise RunError(_nothing(rows, keys))
    if step is None:
        for row in found:
            print(_line(opened, row))
        return 0
    for number, row in enumerate(found):
        if number:
            print()
        _show(opened, row, prompts)
    return 0


def _nothing(rows: list[dict[str, Any]], keys: dict[str, int]) -> str:
    asked = ", ".join(f"{key} {value}" for key, value in keys.items())
    step = keys.get("step")
    same = [row for row in rows if row["step"] == step]
    if same:
        there = ", ".join(f"team {row['team']} (leader {row['leader']})" for row in same)
        return f"no decision with {asked}: in step {step} decided {there}"
    if step is None:
        return f"no decision with {asked}"
    near = min(rows, key=lambda row: abs(row["step"] - step))
    return (
        f"no decision with {asked}: the nearest is in step {near['step']}, team {near['team']} "
        f"(of {len(rows)}; without --step they are listed)"
    )


def _place(run: Run, row: dict[str, Any]) -> str:
    if row["cell"] is None:
        return "nowhere"
    y, x = run.frame.unflat(row["cell"])
    return f"({x},{y})"


def _line(run: Run, row: dict[str, Any]) -> str:
    reason = f": {clean_line(row['reason'])}" if row["reason"] else ""
    return (
        f"step {row['step']}, team {row['team']}, leader {row['leader']} -> "
        f"{_place(run, row)}{reason}"
    )


def _show(run: Run, row: dict[str, Any], prompts: bool) -> None:
    import json

    import polars as pl

    print(f"step {row['step']}, team {row['team']}, led by robot {row['leader']}")
    print(f"why       {row['cause']}")
    print(f"selector  {row['selector']}, {row['frontiers']} frontiers to choose from")
    attempts = run.attempts.filter(
        (pl.col("step") == row["step"]) & (pl.col("leader") == row["leader"])
    )
    for attempt in attempts.to_dicts():
        _attempt(run, attempt, prompts)
    details = json.loads(row["details"] or "{}")
    if details.get("warm_up"):
        print("model     not asked: during the warm-up, the fallback selector decides")
    if details.get("fallback"):
        print(f"model     no valid answer ({details['fallback']}): the fallback selector decided")
    near = f"{row['frontier_neighbours']} frontier and {row['obstacle_neighbours']} obstacle"
    if row["cell"] is None:
        print("chosen    nothing")
    else:
        print(f"chosen    {_place(run, row)}, {row['distance_m']:.1f} m away, {near} neighbours")
    if row["reason"]:
        print(f"reason    {clean_line(row['reason'])}")
    others = {k: v for k, v in details.items() if k not in ("warm_up", "fallback")}
    if others:
        print("details   " + ", ".join(f"{key} {value}" for key, value in others.items()))


def _attempt(run: Run, attempt: dict[str, Any], prompts: bool) -> None:
    print(
        f"attempt {attempt['attempt']}  {attempt['model']}, encoding {attempt['encoding']}, prompt "
        f"{attempt['prompt_version']} ({attempt['prompt']}), {attempt['candidates']} candidates, "
        f"{attempt['dropped']} cells left out"
    )
    if prompts:
        print(_indented(run.text(attempt["prompt"])))
    said = [f"{attempt['latency_s']:.2f} s, sent {attempt['tries']} times"]
    if attempt["tokens_in"] is not None:
        said.append(f"{attempt['tokens_in']} + {attempt['tokens_out']} tokens")
    if attempt["cost_usd"] is not None:
        said.append(f"${attempt['cost_usd']:.6f}")
    print(f"answer    {', '.join(said)}")
    if prompts and attempt["answer"] is not None:
        print(_indented(run.text(attempt["answer"])))
    note = f" ({clean_line(attempt['note'])})" if attempt["note"] else ""
    print(f"verdict   {attempt['verdict']}{note}")


def _indented(text: str) -> str:
    return "\n".join(f"    {line}" for line in clean_text(text).rstrip("\n").splitlines())
