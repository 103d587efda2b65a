"""A recorded mission that these tests share, and a real browser that shows it.

No test depends on the speed of the machine: they wait for conditions, and :data:`HANG_S` only ends
a test that would never end.
"""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from swarmscout import Run, Scenario, record_mission
from swarmscout.viewing.player.recorded import player_data

HANG_S = 600.0
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
# Without a graphics card Chromium draws WebGL in software.
FLAGS = ["--no-sandbox", "--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


@pytest.fixture(scope="session")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    scenario = Scenario(
        world="lava-tube-small", robots=12, steps=60, seed=4, destinations="nearest"
    )
    return record_mission(scenario, out=tmp_path_factory.mktemp("runs") / "seen")


@pytest.fixture(scope="session")
def data(run: Run) -> bytes:
    return player_data(run)


@pytest.fixture(scope="session")
def chromium() -> Iterator[Any]:
    """A headless Chromium; without one these tests are skipped, and pytest says so."""
    found = os.environ.get("SWARMSCOUT_CHROMIUM") or next(
        filter(None, map(shutil.which, BROWSERS)), None
    )
    if found is None:
        pytest.skip("NO CHROMIUM: the player's page is not tested (apt-get install chromium)")
    driver = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    with driver.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found, args=FLAGS)
        yield browser
        browser.close()


def wait_until(condition: Callable[[], Any], name: str = "") -> None:
    """Wait for a condition, however slow the machine."""
    end = time.monotonic() + HANG_S
    while not condition():
        assert time.monotonic() < end, f"never true: {name}"
        time.sleep(0.05)


class Watched:
    """A page, and everything about it that is wrong."""

    def __init__(self, page: Any) -> None:
        self.page = page
        self.troubles: list[str] = []
        self.requests: list[str] = []
        page.on("console", self._hear)
        page.on("pageerror", lambda error: self.troubles.append(f"error: {error}"))
        page.on("request", lambda request: self.requests.append(request.url))

    def _hear(self, message: Any) -> None:
        # Software WebGL warns that reading pixels is slow, which it is.
        if message.type in ("error", "warning") and "GPU stall" not in message.text:
            self.troubles.append(f"{message.type}: {message.text}")

    def open(self, url: str) -> Any:
        self.page.goto(url)
        self.page.wait_for_selector("body[data-ready=yes]", timeout=1000 * HANG_S)
        return self.page

    def until(self, expression: str) -> None:
        """Wait for a condition (the page's policy forbids Playwright's own way)."""
        wait_until(lambda: self.page.evaluate(expression), expression)

    @property
    def foreign(self) -> list[str]:
        """Requests that left this machine, or this file."""
        ours = ("file:", "data:", "blob:", "http://127.0.0.1:", "http://localhost:")
        return [url for url in self.requests if not url.startswith(ours)]


@pytest.fixture
def watched(chromium: Any) -> Iterator[Callable[..., Watched]]:
    pages: list[Watched] = []

    def make(width: int = 1280, height: int = 720, **more: Any) -> Watched:
        context = chromium.new_context(viewport={"width": width, "height": height}, **more)
        context.set_default_timeout(1000 * HANG_S)
        pages.append(Watched(context.new_page()))
        return pages[-1]

    yield make
    for one in pages:
        one.page.context.close()
