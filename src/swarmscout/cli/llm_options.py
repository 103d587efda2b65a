"""What commands share that ask a language model: their options, and what they say of it."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from swarmscout.mission.mission import Mission
    from swarmscout.mission.scenario import Scenario

__all__ = ["decision_lines", "llm_line", "llm_overrides", "say_others", "say_trouble"]

_PROVIDERS = ("auto", "openai", "azure", "server", "embedded")


def llm_overrides(
    llm: str | None, model: str | None, cassette: Path | None, mode: str | None
) -> dict[str, Any]:
    """Options as scenario keys.

    Raises:
        ScenarioError: ``--llm`` is neither a provider nor an address.
    """
    from swarmscout.core.errors import ScenarioError, did_you_mean

    found: dict[str, Any] = {}
    if llm is not None and "://" in llm:
        found |= {"llm.provider": "server", "llm.base_url": llm}
    elif llm is not None and llm in _PROVIDERS:
        found["llm.provider"] = llm
    elif llm is not None:
        raise ScenarioError(
            f"--llm '{llm}': {did_you_mean(llm, _PROVIDERS)} (or an address such as "
            "http://127.0.0.1:11434/v1)"
        )
    keys = {"llm.model": model, "llm.cassette": cassette, "llm.mode": mode}
    return found | {key: str(value) for key, value in keys.items() if value is not None}


def llm_line(figures: Mapping[str, Any]) -> str:
    """What a language model did in a mission, in one line; empty when none was asked."""
    told = figures.get("llm")
    if not told:
        return ""
    parts = [f"{told['model']}: {told['by_model']} of {told['asked']} decisions it was asked for"]
    for key, word in (("invalid", "invalid answers"), ("fallbacks", "left to the rule")):
        counts = told.get(key) or {}
        if counts:
            names = ", ".join(f"{name} {count}" for name, count in counts.items())
            parts.append(f"{sum(counts.values())} {word} ({names})")
    parts.append(f"{told['calls']} calls, {told['tokens_in']:,} + {told['tokens_out']:,} tokens")
    if told.get("cost_usd"):
        parts.append(f"${told['cost_usd']:.2f}")
    return "; ".join(parts)


def say_trouble(figures: Mapping[str, Any] | None) -> None:
    """Say on stderr that a model stopped answering, and what decided instead."""
    told = (figures or {}).get("llm")
    if told and told.get("trouble"):
        print(
            f"warning: the model did not answer to the end: {told['trouble']}; the rule without a "
            f"model took {sum(told['fallbacks'].values())} decisions instead",
            file=sys.stderr,
        )


def decision_lines(mission: Mission) -> list[str]:
    """A line for each decision of the last step for which a model was asked."""
    lines = []
    for decision in mission.decisions:
        told = decision.details.get("fallback", "")
        if (not decision.attempts and not told) or decision.cell is None:
            continue
        why = f"left to the rule ({told})" if told else decision.reason or "no reason given"
        lines.append(
            f"step {decision.step:3d}  robot {decision.leader:2d} -> "
            f"({decision.cell[1]},{decision.cell[0]}), {decision.distance_m:.1f} m: {why}"
        )
    return lines


def say_others(scenario: Scenario) -> None:
    """After a mission with the embedded model: what it is for, and how to ask a better one."""
    if scenario.llm.provider != "embedded" or not scenario.destinations.startswith("llm"):
        return
    again = f"swarmscout explore --destinations {scenario.destinations}"
    print("The embedded model shows the whole path; it explores no better than chance. Others:")
    print(f"  OpenAI  OPENAI_API_KEY=... {again} --llm openai --llm-model gpt-4o")
    print("  Azure   AZURE_OPENAI_ENDPOINT=... AZURE_OPENAI_API_KEY=... OPENAI_API_VERSION=... \\")
    print(f"          {again} --llm azure --llm-model DEPLOYMENT")
    print(f"  Ollama  {again} --llm http://127.0.0.1:11434/v1 --llm-model NAME")
