"""``swarmscout``: the commands, and how every failure becomes one line.

Modules of commands import heavy packages inside their functions, so that ``--help`` loads neither
NumPy nor Numba.
"""

from __future__ import annotations

import io
import os
import signal
import sys
from collections.abc import Sequence
from typing import Literal

from cyclopts import App, CycloptsError, Parameter

from swarmscout.cli.help_format import TwoColumns
from swarmscout.cli.interrupts import Interrupted, interruptible
from swarmscout.cli.values import convert_value, with_values_joined

__all__ = ["app", "main"]


def _version() -> str:
    from swarmscout import __version__

    return __version__


app = App(
    name="swarmscout",
    help="Explore unknown places with swarms of robots that form teams by themselves.",
    version=_version,
    help_format="plaintext",  # Markdown and Rich's tables take half of the time of --help.
    help_formatter=TwoColumns(),
    default_parameter=Parameter(converter=convert_value),
    suppress_keyboard_interrupt=False,
)
_COMMANDS = {
    "explore": ("explore:explore", "Run a mission: summary, run folder, picture of the map."),
    "view": ("view:view", "Show a recorded mission in the browser, or export it as one file."),
    "figures": ("figures:figures", "Draw figures of a recorded mission, for print."),
    "video": ("video:video", "Make a film of a recorded mission."),
    "study": ("study:study", "Run a study: many missions compared, with a report."),
    "compare": ("compare:compare", "Compare a few runs in a table."),
    "reproduce": ("reproduce:reproduce", "Reproduce the paper's figures from our own runs."),
    "explain": ("explain:explain", "Show a decision in full: prompt, answer, verdict, choice."),
    "verify": ("verify:verify", "Check that a run is what was written, every file of it."),
    "worlds": ("worlds:app", "List, show, import and generate worlds."),
    "list": ("lists:app", "List selectors, policies, sensors, worlds, scenario keys."),
    "schema": ("schema:schema", "Print the JSON schema of a scenario."),
    "check": ("check:check", "Check a plug-in of your own against the contract of its kind."),
    "models": ("models:app", "List and install small local language models."),
    "warm": ("warm:warm", "Compile all kernels now instead of in the first mission."),
    "doctor": ("doctor:doctor", "Show versions, cores and caches, and report problems."),
}
for _name, (_where, _help) in _COMMANDS.items():
    app.command(f"swarmscout.cli.{_where}", name=_name, help=_help)


@app.command(name="--install-completion")
def install_completion(shell: Literal["bash", "zsh", "fish"] | None = None) -> None:
    """Install tab completion for your shell.

    Args:
        shell: which shell; by default the one that runs this command.
    """
    print(f"completion: {app.install_completion(shell=shell)}; it works in new shells")


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Args:
        argv: the words after ``swarmscout``; None for ``sys.argv``.

    Returns:
        The exit code: 0; 2 for what a user can correct; 130 or 143 after an interrupt; 1 for a
        defect of the package. ``SWARMSCOUT_DEBUG=1`` shows tracebacks.
    """
    tokens = with_values_joined(sys.argv[1:] if argv is None else argv)
    # A stream is None where the shell has closed it (``>&-``).
    sys.stdout = sys.stdout or open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    sys.stderr = sys.stderr or open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # A terminal that cannot show "m²" shows "m?".
    try:
        with interruptible():
            code = app(tokens, exit_on_error=False, print_error=False, result_action="return_value")
            sys.stdout.flush()
        return code if isinstance(code, int) else 0
    except Interrupted as stopped:
        return _say(str(stopped), 128 + stopped.signal)
    except KeyboardInterrupt:
        return _say("interrupted", 128 + signal.SIGINT)
    except BrokenPipeError:
        # The reader of our output (``| head``) has closed it. Python would complain at its exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 128 + signal.SIGPIPE
    except SystemExit as left:
        return left.code if isinstance(left.code, int) else _say(str(left.code or ""), 1)
    except Exception as error:
        if os.environ.get("SWARMSCOUT_DEBUG", "0") not in ("", "0"):
            raise
        return _say(*_explain(error))


def _explain(error: Exception) -> tuple[str, int]:
    """What went wrong in one line, and the exit code."""
    from swarmscout.core.errors import SwarmscoutError

    if isinstance(error, SwarmscoutError | CycloptsError):
        return f"error: {error}", 2
    if isinstance(error, MemoryError):
        return "error: not enough memory: take fewer robots, a smaller world or larger cells", 2
    if isinstance(error, OSError):
        where = f": '{error.filename}'" if error.filename else ""
        return f"error: {error.strerror or error}{where}", 2
    if isinstance(error, RuntimeError) and "no locator available" in str(error):
        # Numba compiles into a cache folder and finds none, when the first kernel is imported.
        return "error: no folder for compiled kernels is writable: set NUMBA_CACHE_DIR to one", 2
    kind = type(error).__name__
    return f"error: defect in swarmscout: {kind}: {error} (SWARMSCOUT_DEBUG=1 shows where)", 1


def _say(line: str, code: int) -> int:
    print(" ".join(line.split()), file=sys.stderr)
    return code
