"""Prompt templates: versioned files that users can replace.

They are read when a selector is made, not during the mission.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from string import Template

from swarmscout.core.errors import SelectorError, did_you_mean

__all__ = ["Prompt", "load_prompt", "named_prompts"]

_PARTS = ("version", "system", "user", "answer", "retry")
_NAMES = {
    "system": frozenset[str](),
    "user": frozenset(
        ("legend", "map", "position", "others", "cell_m", "heading", "history", "answer")
    ),
    "answer": frozenset(("form",)),
    "retry": frozenset(("problem",)),
}
_NEEDED = {"user": ("map", "answer")}


@dataclass(frozen=True, slots=True)
class Prompt:
    """A prompt's parts, as templates with ``$names``.

    Attributes:
        version: identifies the prompt in records.
        system, user: the first two messages.
        answer: the form of the answer; ``$answer`` in the user's message.
        retry: the message after an answer that cannot be used; empty: the call is repeated.
    """

    version: str
    system: str
    user: str
    answer: str
    retry: str

    def filled(self, part: str, **values: str) -> str:
        """A part with its names filled in."""
        return Template(getattr(self, part)).substitute(values).strip()


def named_prompts() -> tuple[str, ...]:
    """Names of the package's prompts."""
    folder = resources.files("swarmscout.destinations.llm") / "prompts"
    return tuple(
        sorted(f.name.removesuffix(".toml") for f in folder.iterdir() if f.name.endswith(".toml"))
    )


@cache
def load_prompt(name: str) -> Prompt:
    """Read a prompt.

    Args:
        name: one of :func:`named_prompts`, or a TOML file.

    Raises:
        SelectorError: the prompt does not exist, lacks a part, or uses an unknown name.
    """
    if name in named_prompts():
        file = resources.files("swarmscout.destinations.llm") / "prompts" / f"{name}.toml"
        text = file.read_text(encoding="utf-8")
    elif not name.endswith(".toml"):
        raise SelectorError(
            f"unknown prompt '{name}': {did_you_mean(name, named_prompts())} (or a .toml file)"
        )
    else:
        try:
            text = Path(name).read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            reason = getattr(error, "strerror", None) or "it is not UTF-8 text"
            raise SelectorError(f"prompt file '{name}' cannot be read: {reason}") from None
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SelectorError(f"prompt file '{name}' is not valid TOML: {error}") from None
    return _checked(name, data)


def _checked(name: str, data: dict[str, object]) -> Prompt:
    for key in data:
        if key not in _PARTS:
            raise SelectorError(
                f"prompt '{name}': unknown key '{key}': {did_you_mean(key, _PARTS)}"
            )
    for part in _PARTS:
        if not isinstance(data.get(part), str) or (part != "retry" and not data[part]):
            raise SelectorError(f"prompt '{name}': '{part}' is missing or not a text")
    prompt = Prompt(**{part: str(data[part]) for part in _PARTS})
    for part, known in _NAMES.items():
        template = Template(getattr(prompt, part))
        if not template.is_valid():
            raise SelectorError(f"prompt '{name}', '{part}': write $$ for a dollar sign")
        used = template.get_identifiers()
        for identifier in used:
            if identifier not in known:
                raise SelectorError(
                    f"prompt '{name}', '{part}': unknown name '${identifier}': "
                    f"{did_you_mean(identifier, known)}"
                )
        for needed in _NEEDED.get(part, ()):
            if needed not in used:
                raise SelectorError(f"prompt '{name}', '{part}': it must contain '${needed}'")
    return prompt
