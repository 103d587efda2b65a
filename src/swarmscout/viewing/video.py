"""A run as a video (MP4, by ffmpeg) or as an animated picture (WebP, GIF, by Pillow alone)."""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from PIL import Image

from swarmscout.core.errors import RunError, ViewError
from swarmscout.core.extras import install_command
from swarmscout.viewing.film import Film
from swarmscout.viewing.replay import Replay

if TYPE_CHECKING:
    from swarmscout.recording.run import Run

__all__ = ["ffmpeg_program", "make_video"]

FORMS = (".mp4", ".webp", ".gif")
LEAST, MOST = 160, 4096


def make_video(
    run: Run,
    file: str | Path,
    *,
    size: tuple[int, int] = (1280, 720),
    fps: float = 30.0,
    every: int = 1,
    on_frame: Callable[[int, int], None] | None = None,
) -> Path:
    """Make a film of a run.

    Args:
        run: recorded with ``record="full"``.
        file: the film; its suffix says the form: .mp4, .webp or .gif.
        size: ``(width, height)`` in pixels, both even.
        fps: frames per second.
        every: a frame for every so many steps; the last step always has one.
        on_frame: called with the frames drawn so far and all that there will be.

    Returns:
        The file, which appears when it is whole.

    Raises:
        RunError: the run cannot be shown, or the file cannot be written.
        ViewError: an argument is impossible, or no ffmpeg is there.

    Example:
        >>> make_video(Run.open("runs/mine"), "mine.mp4")  # doctest: +SKIP
    """
    path = Path(file)
    form = path.suffix.lower()
    if form not in FORMS:
        raise ViewError(f"'{path}': a film's name ends in {', '.join(FORMS)}")
    if not all(LEAST <= side <= MOST and side % 2 == 0 for side in size):
        width, height = size
        raise ViewError(
            f"size {width}x{height}: give even numbers from {LEAST} to {MOST}, for example 1280x720"
        )
    if not 0.1 <= fps <= 120.0:
        raise ViewError(f"{fps:g} frames per second: give 0.1 to 120")
    if every < 1:
        raise ViewError(f"a frame for every {every} steps: give 1 or more")
    program = ffmpeg_program() if form == ".mp4" else ""
    replay = Replay(run)
    steps = [*range(0, replay.last, every), replay.last]

    film = Film(replay, size)

    def frames() -> Iterator[Image.Image]:
        for done, step in enumerate(steps, start=1):
            yield film.frame(step)
            if on_frame is not None:
                on_frame(done, len(steps))

    with _put_in_place(path) as unfinished:
        if form == ".mp4":
            _encode(program, frames(), size, fps, unfinished)
        else:
            # The last frame has all the colours.
            _animate(form, frames(), film.frame(replay.last), fps, unfinished)
    return path


def ffmpeg_program() -> str:
    """The ffmpeg to use: the system's, or the one of the package ``imageio-ffmpeg``.

    Raises:
        ViewError: there is none.
    """
    found = os.environ.get("SWARMSCOUT_FFMPEG") or shutil.which("ffmpeg")
    if found:
        return found
    try:
        from imageio_ffmpeg import get_ffmpeg_exe

        return str(get_ffmpeg_exe())
    except (ImportError, RuntimeError):
        raise ViewError(
            f"no ffmpeg for .mp4: install it, or {install_command('video')}; "
            ".webp and .gif need none"
        ) from None


@contextlib.contextmanager
def _put_in_place(path: Path) -> Iterator[Path]:
    """A file beside the wanted one, which replaces it when nothing went wrong."""
    try:
        handle, name = tempfile.mkstemp(prefix=".film-", suffix=path.suffix, dir=path.parent)
        os.close(handle)
    except OSError as error:
        raise RunError(f"cannot write '{path}': {error.strerror or error}") from None
    unfinished = Path(name)
    try:
        yield unfinished
        unfinished.chmod(0o666 & ~_umask())
        unfinished.replace(path)
    except OSError as error:
        raise RunError(f"cannot write '{path}': {error.strerror or error}") from None
    finally:
        unfinished.unlink(missing_ok=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _encode(
    program: str, frames: Iterator[Image.Image], size: tuple[int, int], fps: float, file: Path
) -> None:
    """Pipe frames into ffmpeg; what it complains about goes into the error."""
    command = [
        program, "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24",
        "-s", f"{size[0]}x{size[1]}", "-r", f"{fps:g}", "-i", "-",
        "-c:v", "libx264", "-preset", "veryfast", "-crf", "21", "-pix_fmt", "yuv420p",
        "-movflags", "+faststart", str(file),
    ]  # fmt: skip
    with tempfile.TemporaryFile() as told:
        try:
            process = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=told)
        except OSError as error:
            raise ViewError(f"cannot start '{program}': {error.strerror or error}") from None
        assert process.stdin is not None
        try:
            with contextlib.suppress(BrokenPipeError):  # Its own words say why.
                for frame in frames:
                    process.stdin.write(frame.tobytes())
                process.stdin.close()
        except BaseException:
            process.kill()
            raise
        finally:
            with contextlib.suppress(BrokenPipeError):
                process.stdin.close()
            failed = process.wait()
        if failed:
            raise ViewError(f"'{program}' cannot make the film: {_last_line(told)}")


def _last_line(told: IO[bytes]) -> str:
    told.seek(0)
    lines = told.read().decode(errors="replace").strip().splitlines()
    return lines[-1] if lines else "it does not say why"


def _animate(
    form: str, frames: Iterator[Image.Image], colourful: Image.Image, fps: float, file: Path
) -> None:
    """Write an animated picture; one palette for all frames of a GIF, so that nothing flickers."""
    more: dict[str, Any] = {"method": 0, "quality": 80}
    if form == ".gif":
        more = {"optimize": False}
        palette = colourful.quantize(200, method=Image.Quantize.MEDIANCUT)
        frames = (frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames)
    pause_ms = round(1000 / fps)
    next(frames).save(file, save_all=True, append_images=frames, duration=pause_ms, loop=0, **more)
