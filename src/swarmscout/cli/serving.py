"""Serving a page until somebody has seen enough."""

from __future__ import annotations

import sys
import threading
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from swarmscout.viewing.player.server import PlayerServer

__all__ = ["open_page", "serve_until_interrupted"]


def open_page(server: PlayerServer, *, browser: bool) -> None:
    """Say where the page is, and open it."""
    print(f"page: {server.url} (Ctrl-C ends)", flush=True)
    if browser:
        import webbrowser

        # A browser may take its time to come up, or be missing: the mission does not wait.
        threading.Thread(target=webbrowser.open, args=(server.url,), daemon=True).start()


def serve_until_interrupted(server: PlayerServer, *, browser: bool) -> None:
    """Open the page and answer until Ctrl-C, which is the usual way to end."""
    from swarmscout.cli.interrupts import Interrupted, interruptible

    open_page(server, browser=browser)
    try:
        # Polars takes SIGINT for itself when it first reads a table: take it back.
        with interruptible():
            threading.Event().wait()
    except Interrupted:
        if sys.stderr.isatty():
            print(file=sys.stderr)  # The shell's prompt begins a line of its own after "^C".
