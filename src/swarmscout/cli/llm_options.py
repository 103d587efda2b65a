"""Options and output of the commands that use a language model."""

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
    """What a language model did in a mission, in one line; empty when none was used."""
    llm = figures.get("llm")
    if not llm:
        return ""
    parts = [f"{llm['model']}: {llm['by_model']} of {llm['asked']} decisions it was asked for"]
    for key, word in (("invalid", "invalid answers"), ("fallbacks", "left to the rule")):
        counts = llm.get(key) or {}
        if counts:
            names = ", ".join(f"{name} {count}" for name, count in counts.items())
            parts.append(f"{sum(counts.values())} {word} ({names})")
    parts.append(f"{llm['calls']} calls, {llm['tokens_in']:,} + {llm['tokens_out']:,} tokens")
    if llm.get("cost_usd"):
        parts.append(f"${llm['cost_usd']:.2f}")
    return "; ".join(parts)


def say_trouble(figures: Mapping[str, Any] | None) -> int:
    """Say on stderr what was wrong with the model, and what decided instead.

    Returns:
        The command's exit code: 3 if the model was asked and made no decision, else 0.
    """
    llm = (figures or {}).get("llm")
    if not llm:
        return 0
    if llm.get("notes"):
        print(f"note: {llm['notes']}", file=sys.stderr)
    never = llm["asked"] > 0 and llm["by_model"] == 0
    if llm.get("trouble") or never:
        invalid = ", ".join(llm.get("invalid") or {})
        why = llm.get("trouble") or (f"invalid answers ({invalid})" if invalid else "no answers")
        what = "made no decision" if never else "did not answer to the end"
        print(
            f"warning: the model {what}: {why}; the rule without a model took "
            f"{sum(llm['fallbacks'].values())} decisions instead",
            file=sys.stderr,
        )
    return 3 if never else 0


def decision_lines(mission: Mission) -> list[str]:
    """One line per decision of the last step for which a model was asked."""
    lines = []
    for decision in mission.decisions:
        fallback = decision.details.get("fallback", "")
        if (not decision.attempts and not fallback) or decision.cell is None:
            continue
        why = f"left to the rule ({fallback})" if fallback else decision.reason or "no reason given"
        lines.append(
            f"step {decision.step:3d}  robot {decision.leader:2d} -> "
            f"({decision.cell[1]},{decision.cell[0]}), {decision.distance_m:.1f} m: {why}"
        )
    return lines


def say_others(scenario: Scenario) -> None:
    """Print, after a mission with the embedded model, how to use a better one."""
    if scenario.llm.provider != "embedded" or not scenario.destinations.startswith("llm"):
        return
    again = f"swarmscout explore --destinations {scenario.destinations}"
    print("The embedded model is for first steps: it explores no better than chance. Others:")
    print(f"  OpenAI  OPENAI_API_KEY=... {again} --llm openai --llm-model gpt-4o")
    print("  Azure   AZURE_OPENAI_ENDPOINT=... AZURE_OPENAI_API_KEY=... OPENAI_API_VERSION=... \\")
    print(f"          {again} --llm azure --llm-model DEPLOYMENT")
    print(f"  Ollama  {again} --llm http://127.0.0.1:11434/v1 --llm-model NAME")
