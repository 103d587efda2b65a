"""``python -m swarmscout`` and ``swarmscout``: the command line, from the first moment on."""

from __future__ import annotations

import signal
import sys

from swarmscout.cli.interrupts import Interrupted, interruptible


def main() -> int:
    """Run the command line; a signal while it is being loaded is one line too."""
    try:
        with interruptible():
            from swarmscout.cli.app import main as run
        return run()
    except (Interrupted, KeyboardInterrupt) as stopped:
        print(str(stopped) or "interrupted", file=sys.stderr)
        return 128 + getattr(stopped, "signal", signal.SIGINT)


if __name__ == "__main__":
    sys.exit(main())
