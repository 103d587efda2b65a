"""A figure of the explored area over time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from swarmscout.viewing.figures.style import CURVE
from swarmscout.viewing.replay import Curve, Replay

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["explored_area"]


def explored_area(replay: Replay | Curve, step: int) -> Figure:
    """Explored area over the steps, in m² and as a share of the reachable; a mark at the step."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(3.4, 2.3), layout="constrained")
    axes = figure.add_subplot()
    area = replay.explored_m2
    axes.plot(np.arange(len(area)), area, color=CURVE, linewidth=1.4)
    if step < replay.last:
        axes.axvline(step, color="#777777", linewidth=0.7)
    axes.set(
        xlim=(0, max(1, replay.last)), ylim=(0, None), xlabel="step", ylabel="explored area (m²)"
    )
    axes.grid(color="#e2e2e2", linewidth=0.5)
    axes.spines[["top", "right"]].set_visible(False)
    fraction = replay.run.coverage["explored_fraction"].to_numpy()
    if len(fraction) and fraction[-1] > 0:
        reachable_m2 = float(replay.run.coverage["explored_m2"][-1]) / float(fraction[-1])
        share = axes.twinx()
        share.set_ylim(0, 100.0 * axes.get_ylim()[1] / reachable_m2)
        share.spines[["top"]].set_visible(False)
        share.set_ylabel("of what is reachable (%)")
    return figure
