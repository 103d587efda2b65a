"""Failures of one attempt to reach a model, named as in ``core.language_model.FAILURES``."""

from __future__ import annotations

__all__ = ["FINAL", "HOPELESS", "TryFailed"]

FINAL = ("unauthorized", "not found", "bad request", "too long")
"""Trying the same again is pointless."""

HOPELESS = ("unauthorized", "not found")
"""Asking anything again is pointless for the rest of a mission."""


class TryFailed(Exception):
    """One try failed.

    Attributes:
        kind: one of ``FAILURES``.
        note: more, in a few words and without any key.
        retry_after_s: how long the server asked to wait.
    """

    def __init__(self, kind: str, note: str = "", retry_after_s: float | None = None) -> None:
        super().__init__(f"{kind}: {note}" if note else kind)
        self.kind = kind
        self.note = note
        self.retry_after_s = retry_after_s
