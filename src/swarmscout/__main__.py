"""``python -m swarmscout`` and ``swarmscout``: the command line, from the first moment on."""

from __future__ import annotations

import os
import signal
import sys

from swarmscout.cli.interrupts import Interrupted, ending_in_time, interruptible

_STOPPED = tuple(128 + number for number in (signal.SIGINT, signal.SIGTERM))


def main() -> int:
    """Run the command line; a signal while it is being loaded is one line too."""
    with ending_in_time():
        try:
            with interruptible():
                from swarmscout.cli.app import main as run
            code = run()
        except (Interrupted, KeyboardInterrupt) as stopped:
            print(str(stopped) or "interrupted", file=sys.stderr)
            code = 128 + getattr(stopped, "signal", signal.SIGINT)
        if code in _STOPPED:
            # Python would wait for threads at its exit, for example for a model's answer.
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(code)
    return code


if __name__ == "__main__":
    sys.exit(main())
