"""``explore --view``: the page of a running mission."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from swarmscout.viewing.player.live import LiveMission
    from swarmscout.viewing.player.server import PlayerServer

__all__ = ["Watching", "watching"]


class Watching:
    """A running mission's page.

    Attributes:
        live: the recorder that the mission needs.
    """

    def __init__(self, live: LiveMission, server: PlayerServer, pace: float | None) -> None:
        self.live = live
        self._server = server
        self._pause_s = 0.0 if pace is None else 1.0 / pace
        self._due = time.monotonic()

    def keep_pace(self) -> None:
        """Wait until the next step is due."""
        if self._pause_s:
            now = time.monotonic()
            self._due = max(self._due + self._pause_s, now)
            time.sleep(self._due - now)

    def close_unless_over(self) -> None:
        """Close the page if the mission was stopped."""
        if self.live.ending() is None:
            self.live.broken_off()
            self._server.stop()

    def stay(self) -> None:
        """Keep the page open after the mission, until Ctrl-C."""
        from swarmscout.cli.serving import serve_until_interrupted

        try:
            serve_until_interrupted(self._server, browser=False)
        finally:
            self._server.stop()


def watching(
    name: str, *, host: str, port: int | None, browser: bool, pace: float | None
) -> Watching:
    """Open a page for a mission before its first step.

    Raises:
        ViewError: the address cannot be bound, or the pace is not positive.
    """
    from swarmscout.cli.serving import open_page
    from swarmscout.core.errors import ViewError
    from swarmscout.viewing.player.live import LiveMission
    from swarmscout.viewing.player.server import PlayerServer

    if pace is not None and not pace > 0:
        raise ViewError(f"--pace {pace:g}: steps per second must be more than 0")
    live = LiveMission(name)
    server = PlayerServer([live], host, port)
    server.start()
    open_page(server, browser=browser)
    return Watching(live, server, pace)
