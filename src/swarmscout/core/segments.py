"""Straight ways, inside kernels."""

from __future__ import annotations

from swarmscout.core.jit import inlined

__all__ = ["way_distance2"]


@inlined
def way_distance2(x, y, dx, dy, px, py):  # type: ignore[no-untyped-def]
    """Squared distance from a point p to the way from (x, y) to (x + dx, y + dy)."""
    length2 = dx * dx + dy * dy
    t = 0.0
    if length2 > 0.0:
        t = min(1.0, max(0.0, ((px - x) * dx + (py - y) * dy) / length2))
    ex = x + t * dx - px
    ey = y + t * dy - py
    return ex * ex + ey * ey
