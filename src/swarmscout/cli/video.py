"""``swarmscout video``: a film of a mission."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

__all__ = ["video"]


def video(
    run: Path,
    /,
    *,
    out: Annotated[Path, Parameter(name=["--out", "-o"], metavar="FILE.mp4")] = Path("mission.mp4"),
    size: Annotated[str, Parameter(metavar="WxH")] = "1280x720",
    fps: float = 30.0,
    every: int = 1,
) -> int:
    """Make a film of a mission: the cave, the map and the explored area.

    MP4 is advised: it is sharper than a GIF and shows every step. A GIF shows every second frame.

    Args:
        run: a run's folder, of a finished mission or of a killed one.
        out: the film: .mp4 (advised; needs ffmpeg), .webp or .gif.
        size: width and height in pixels.
        fps: frames per second.
        every: steps per frame.
    """
    from swarmscout.cli.counting import counting
    from swarmscout.core.errors import ViewError
    from swarmscout.recording.run import Run
    from swarmscout.viewing.video import make_video

    width, cross, height = size.lower().partition("x")
    if not (cross and width.isdecimal() and height.isdecimal()):
        raise ViewError(f"size '{size}': write WIDTHxHEIGHT, for example 1280x720")
    pixels = int(width), int(height)
    with counting("frames") as on_frame:
        file = make_video(Run.open(run), out, size=pixels, fps=fps, every=every, on_frame=on_frame)
    print(f"film: {file} ({file.stat().st_size / 1e6:.1f} MB)")
    return 0
