"""Parameters of a radio."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from swarmscout.core.parameters import Parameters

__all__ = ["RadioParameters", "radio_parameters"]


class RadioParameters(Parameters):
    """Who hears whom (paper, "Robot model": full communication)."""

    model: str = Field("full", min_length=1, description="a radio, or FILE.py:NAME")
    range_m: float = Field(
        10.0, ge=0.0, le=1e9, description="'disc': largest distance at which robots hear each other"
    )
    parameters: dict[str, Any] = Field(
        default_factory=dict, description="parameters of a radio from a file or another package"
    )


def radio_parameters(given: RadioParameters) -> dict[str, Any]:
    """What a radio's class is made with.

    Args:
        given: the section ``[radio]``.
    """
    return {"range_m": given.range_m} if given.model == "disc" else dict(given.parameters)
