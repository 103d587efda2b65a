"""Parameters of team formation."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from swarmscout.core.parameters import Parameters, Steps

__all__ = ["TeamParameters"]


class TeamParameters(Parameters):
    """Team formation (paper, "Decentralized team formation" and "Self-organization")."""

    policy: str = Field(
        "by-mode",
        min_length=1,
        description="policy for the desired team size: a name, or FILE.py:NAME",
    )
    desired_size: int = Field(5, ge=1, le=100_000, description="desired team size in EXP mode")
    d_join_m: float = Field(
        2.0, ge=0.0, le=1e6, description="largest distance at which teams may join"
    )
    leave_rule: Literal["charge", "general"] = Field(
        "charge", description="'general': also leave when mean desired size < team size"
    )
    silence_steps: Steps = Field(
        5, description="a member that was not heard for more steps than this is dropped"
    )
    position: Literal["leader", "center"] = Field(
        "leader", description="a team's position: its leader's, or the mean of its members'"
    )
