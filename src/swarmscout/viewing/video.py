"""A run as a film: MP4 by ffmpeg, which is advised, or WebP and GIF by Pillow alone."""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from PIL import Image

from swarmscout.core.errors import RunError, ViewError
from swarmscout.core.extras import install_command
from swarmscout.viewing.film import Film
from swarmscout.viewing.palette import DARK, rgb
from swarmscout.viewing.replay import Replay

if TYPE_CHECKING:
    from swarmscout.recording.run import Run

__all__ = ["ffmpeg_program", "make_video"]

FORMS = (".mp4", ".webp", ".gif")
LEAST, MOST = 160, 4096
_GIF_COLOURS = 240
_PLAIN = Image.Dither.NONE


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
        file: the film; its suffix chooses the format: .mp4, .webp or .gif.
        size: ``(width, height)`` in pixels, both even.
        fps: frames per second. A GIF shows every second frame, twice as long.
        every: steps per frame; the last step always has a frame.
        on_frame: called with the number of frames drawn and of all frames.

    Returns:
        The file, which appears once it is complete.

    Raises:
        RunError: the run cannot be shown, or the file cannot be written.
        ViewError: an argument is impossible, or ffmpeg is missing.

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
            f"size {width}x{height}: choose even numbers from {LEAST} to {MOST}, such as 1280x720"
        )
    if not 0.1 <= fps <= 120.0:
        raise ViewError(f"{fps:g} frames per second: choose 0.1 to 120")
    if every < 1:
        raise ViewError(f"a frame for every {every} steps: choose 1 or more")
    program = ffmpeg_program() if form == ".mp4" else ""
    if form == ".gif":
        every, fps = 2 * every, fps / 2.0
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
        elif form == ".webp":
            _animate(frames(), fps, unfinished, method=0, quality=80)
        else:
            palette = _palette_of([film.frame(step) for step in steps[:: max(1, len(steps) // 4)]])
            plain = (frame.quantize(palette=palette, dither=_PLAIN) for frame in frames())
            _animate(plain, fps, unfinished, optimize=True, disposal=1)
    return path


def ffmpeg_program() -> str:
    """The system's ffmpeg, or that of the package ``imageio-ffmpeg``.

    Raises:
        ViewError: neither is installed.
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
    """A temporary file in the same folder, which takes the film's name at the end."""
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
    """Pipe frames into ffmpeg; its last line of complaint goes into the error."""
    command = [
        program, "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24",
        "-s", f"{size[0]}x{size[1]}", "-r", f"{fps:g}", "-i", "-",
        "-c:v", "libx264", "-preset", "veryfast", "-crf", "21", "-pix_fmt", "yuv420p",
        "-movflags", "+faststart", str(file),
    ]  # fmt: skip
    with tempfile.TemporaryFile() as complaints:
        try:
            process = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=complaints)
        except OSError as error:
            raise ViewError(f"cannot start '{program}': {error.strerror or error}") from None
        assert process.stdin is not None
        try:
            with contextlib.suppress(BrokenPipeError):  # The complaint below says why.
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
            raise ViewError(f"'{program}' cannot make the film: {_last_line(complaints)}")


def _last_line(output: IO[bytes]) -> str:
    output.seek(0)
    lines = output.read().decode(errors="replace").strip().splitlines()
    return lines[-1] if lines else "it gives no reason"


def _animate(frames: Iterator[Image.Image], fps: float, file: Path, **options: Any) -> None:
    """Write an animated picture that repeats forever."""
    pause_ms = round(1000 / fps)
    next(frames).save(
        file, save_all=True, append_images=frames, duration=pause_ms, loop=0, **options
    )


def _palette_of(frames: Sequence[Image.Image]) -> Image.Image:
    """One palette for all frames, so that nothing flickers: signs keep their exact colours.

    The rest of the palette is shared among the colours of some frames. One entry stays free, for
    pixels that do not change.
    """
    signs = [rgb(colour) for colour in vars(DARK).values()] + [(255, 255, 255)]
    together = Image.new("RGB", (frames[0].width, frames[0].height * len(frames)))
    for k, frame in enumerate(frames):
        together.paste(frame, (0, k * frame.height))
    room = _GIF_COLOURS - len(signs)
    rest = together.quantize(room, method=Image.Quantize.MEDIANCUT).getpalette() or []
    palette = Image.new("P", (1, 1))
    palette.putpalette([*(part for colour in signs for part in colour), *rest[: 3 * room]])
    return palette
