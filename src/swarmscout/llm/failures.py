"""Failures of one attempt to reach a model, named as in ``core.language_model.FAILURES``."""

from __future__ import annotations

__all__ = ["FINAL", "TryFailed"]

FINAL = ("unauthorized", "forbidden", "not found", "bad request", "too long")
"""Failures after which the same request is not sent again."""


class TryFailed(Exception):
    """One attempt failed.

    Attributes:
        kind: one of ``FAILURES``.
        note: details in one line, without any key.
        retry_after_s: how long the server asked to wait, in seconds.
    """

    def __init__(self, kind: str, note: str = "", retry_after_s: float | None = None) -> None:
        super().__init__(f"{kind}: {note}" if note else kind)
        self.kind = kind
        self.note = note
        self.retry_after_s = retry_after_s
