"""Serving a page until Ctrl-C."""

from __future__ import annotations

import sys
import threading
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from swarmscout.viewing.player.server import PlayerServer

__all__ = ["open_page", "serve_until_interrupted"]


def open_page(server: PlayerServer, *, browser: bool) -> None:
    """Print the page's address, and open it."""
    print(f"page: {server.url} (Ctrl-C ends)", flush=True)
    if server.opened is not None:
        print(f"warning: {server.opened}", file=sys.stderr, flush=True)
    if browser:
        import webbrowser

        # A browser may start slowly, or be missing: the mission does not wait.
        threading.Thread(target=webbrowser.open, args=(server.url,), daemon=True).start()


def serve_until_interrupted(server: PlayerServer, *, browser: bool) -> None:
    """Open the page and serve it until Ctrl-C."""
    from swarmscout.cli.interrupts import Interrupted, interruptible

    open_page(server, browser=browser)
    try:
        # Polars replaces the SIGINT handler when it first reads a table.
        with interruptible():
            threading.Event().wait()
    except Interrupted:
        if sys.stderr.isatty():
            print(file=sys.stderr)  # The shell's prompt begins a line of its own after "^C".
