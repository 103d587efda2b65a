"""The part of a model's text that is its answer: without reasoning, fences and special tokens."""

from __future__ import annotations

import re

__all__ = ["Unfinished", "answer_in", "plain_signs"]

_TAG = re.compile(
    r"[<\[◁](/?)(?:think|thinking|thought|thoughts|reasoning|analysis|reflection|scratchpad)[>\]▷]",
    re.IGNORECASE,
)
_THOUGHT_TOKEN = re.compile(r"<\|(begin|end)_of_thought\|>")
_CHANNEL = re.compile(r"<\|channel\|>\s*(\w{1,20})[^<]{0,40}<\|message\|>")
_TOKEN = re.compile(r"<\|\w{1,40}\|>|</?s>")
_FENCE = re.compile(r"^[ \t]{0,20}(?:```|~~~)[\w-]{0,20}[ \t]*$|```(?:json)?", re.MULTILINE | re.I)

# Signs that look like the ones that JSON and coordinates are written with.
_SIGNS: dict[int, int | str] = {
    **{0xFF01 + k: 0x21 + k for k in range(0x5E)},
    **dict.fromkeys(map(ord, "“”„‟«»"), '"'),
    **dict.fromkeys(map(ord, "‘’‚‛"), "'"),
    **dict.fromkeys(map(ord, "−‐‑–"), "-"),
    **dict.fromkeys(map(ord, "\u00a0\u202f\u2009\u3000"), " "),
    ord("、"): ",",
}


class Unfinished(Exception):
    """The text ends before its answer begins."""


def plain_signs(text: str) -> str:
    """A text with typographic quotes, full-width signs and minus signs written in ASCII."""
    return text.translate(_SIGNS)


def answer_in(text: str) -> str:
    """The part of a text behind its reasoning.

    Args:
        text: all that the model wrote.

    Raises:
        Unfinished: the reasoning does not end.
    """
    return _FENCE.sub("\n", _TOKEN.sub(" ", _without_tags(_final_channel(text)))).strip()


def _final_channel(text: str) -> str:
    """The final channel of a text in OpenAI's Harmony format; any other text as it is."""
    channels = list(_CHANNEL.finditer(text))
    if channels:
        if channels[-1].group(1) != "final":
            raise Unfinished
        return text[channels[-1].end() :]
    # The same format after a server has removed the special tokens.
    if text.startswith("analysis") and "assistantfinal" in text:
        return text.rsplit("assistantfinal", 1)[1]
    return text


def _without_tags(text: str) -> str:
    """A text without what stands between tags such as ``<think>`` and ``</think>``."""
    text = _THOUGHT_TOKEN.sub(lambda m: "<think>" if m[1] == "begin" else "</think>", text)
    kept: list[str] = []
    at, inside = 0, False
    for tag in _TAG.finditer(text):
        if tag.group(1):
            if not inside:
                kept.clear()  # Some servers leave the opening tag out.
            at, inside = tag.end(), False
        elif not inside:
            kept.append(text[at : tag.start()])
            inside = True
    if inside:
        raise Unfinished
    return "".join([*kept, text[at:]])
