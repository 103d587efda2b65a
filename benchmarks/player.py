"""What the player costs: sizes, first picture, scrubbing, live view, films.

    python benchmarks/player.py

Needs Linux, a Chromium (apt-get install chromium) and the extra ``dev``. The page is shown by a
headless Chromium that draws WebGL in software. Times are the best of a few; CPU time is that of all
processes of the browser.
"""

from __future__ import annotations

import argparse
import os
import resource
import shutil
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import swarmscout as ss
from swarmscout.recording.tables import OWN_MAPS
from swarmscout.viewing.player.export import export_page
from swarmscout.viewing.player.live import LiveMission
from swarmscout.viewing.player.server import PlayerServer
from swarmscout.viewing.video import make_video

FLAGS = ["--no-sandbox", "--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
SCRUB = """(steps) => new Promise((done) => {
    const last = player.clock.last;
    const times = [];
    let before = performance.now();
    const frame = () => {
        const now = performance.now();
        times.push(now - before);
        before = now;
        if (times.length > steps) done(times.slice(1));
        // Back and forth over all of the mission, as a hand on the slider does.
        else {
            player.clock.goTo(last * Math.abs(Math.sin(times.length / 9)));
            requestAnimationFrame(frame);
        }
    };
    requestAnimationFrame(frame);
})"""


def main() -> None:
    argparse.ArgumentParser(description=__doc__.splitlines()[0]).parse_args()
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        small = ss.explore(
            robots=100, steps=300, destinations="multi-criteria", world="lava-tube-wide",
            out=place / "n100",
        )  # fmt: skip
        large = ss.explore(
            robots=500, steps=3000, destinations="nearest", world="lava-tube-wide",
            start="spread", out=place / "n500", battery={"enabled": False},
        )  # fmt: skip
        pages = {}
        for name, run in (("N = 100, 300 steps", small), ("N = 500, 3,000 steps", large)):
            began = time.process_time()
            pages[name] = export_page([run], place / f"{run.path.name}.html")
            took = time.process_time() - began
            size = pages[name].stat().st_size / 1e6
            print(f"{name} ({run.last_step} run): one file {size:.2f} MB, {took:.1f} s of CPU")
        own_maps(place)
        show_pages(pages)
        live_view()
        film(small, place)


class ByRange:
    """Robots hear each other over 8 m; a recorder, for it must know where they are."""

    def begin(self, mission: Any) -> None:
        """Take the mission."""
        self._mission = mission

    def record(self, record: Any) -> None:
        """A step says nothing new."""

    def end(self, summary: Any) -> None:
        """So does the end."""

    def __call__(self, step: int) -> Any:
        """Who hears whom."""
        gaps = self._mission.bodies.position[:, None] - self._mission.bodies.position[None]
        return (gaps**2).sum(axis=2) <= 8.0**2


def own_maps(place: Path) -> None:
    """What it costs that each robot has a map of its own."""
    for start in ("one-place", "spread"):
        links = ByRange()
        scenario = ss.Scenario(robots=100, steps=300, world="lava-tube-wide", start=start)
        run = ss.record_mission(
            scenario, out=place / start, links=links, watchers=[links], record="full"
        )
        sizes = [(run.path / f"{name}.parquet").stat().st_size / 1e6 for name in OWN_MAPS]
        began = time.process_time()
        run.map_at(robot=7)
        took = time.process_time() - began
        pages = [
            export_page([run], place / "own.html", own_maps=whose).stat().st_size / 1e6
            for whose in ("none", "7", "all")
        ]
        print(
            f"own maps, N = 100, {run.last_step} steps, {start}: {sum(sizes):.2f} MB on disk, "
            f"one robot's last map {took:.2f} s of CPU; one file {pages[0]:.2f} MB without, "
            f"{pages[1]:.2f} MB with one robot's, {pages[2]:.2f} MB with all"
        )


def show_pages(pages: dict[str, Path]) -> None:
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        for name, page_file in pages.items():
            first, frames, cpu_first, cpu_frame = [], [], [], []
            for _ in range(3):
                browser = playwright.chromium.launch(
                    executable_path=shutil.which("chromium"), args=FLAGS
                )
                page = browser.new_page(viewport={"width": 1280, "height": 720})
                began = time.perf_counter()
                used = browsers_cpu_s()
                page.goto(page_file.as_uri())
                page.wait_for_selector("body[data-ready=yes]", timeout=60_000)
                first.append(time.perf_counter() - began)
                cpu_first.append(browsers_cpu_s() - used)
                page.evaluate(SCRUB, 30)  # It finds out how fast this machine is.
                used = browsers_cpu_s()
                frames.append(sorted(page.evaluate(SCRUB, 60)))
                cpu_frame.append((browsers_cpu_s() - used) / 60 * 1000)
                browser.close()
            middle = min(frame[len(frame) // 2] for frame in frames)
            slow = min(frame[int(len(frame) * 0.9)] for frame in frames)
            print(f"{name}: first picture {min(first):.2f} s, {min(cpu_first):.2f} s of CPU")
            print(
                f"{name}: scrubbing, {middle:.0f} ms per frame, nine in ten below {slow:.0f} ms, "
                f"{min(cpu_frame):.0f} ms of CPU on all cores"
            )


def browsers_cpu_s() -> float:
    """CPU time of all processes that this one has started, directly or not (Linux)."""
    parent, used = {}, {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(") ")[2].split()
        except OSError:
            continue  # It has ended meanwhile.
        pid = int(stat.parent.name)
        parent[pid], used[pid] = int(fields[1]), int(fields[11]) + int(fields[12])

    def ours(pid: int) -> bool:
        while pid > 1:
            pid = parent.get(pid, 0)
            if pid == os.getpid():
                return True
        return False

    return sum(ticks for pid, ticks in used.items() if ours(pid)) / os.sysconf("SC_CLK_TCK")


def live_view() -> None:
    """CPU time per step of a mission with N = 100, watched by one browser's worth of reading."""
    import threading
    import urllib.request

    scenario = ss.Scenario(robots=100, steps=300, destinations="nearest")

    def cpu(live: LiveMission | None) -> float:
        mission = ss.Mission(scenario, recorder=live)
        began = time.process_time()
        mission.run()
        return (time.process_time() - began) / mission.step_number * 1000

    def watched() -> float:
        live = LiveMission()
        with PlayerServer([live], port=0) as server:

            def read() -> None:
                with urllib.request.urlopen(f"{server.url}run/0/live?from=0") as answer:
                    while answer.read1(65536):
                        pass

            reader = threading.Thread(target=read, daemon=True)
            reader.start()
            took = cpu(live)
            reader.join(timeout=20)
        return took

    cpu(None)
    alone = min(cpu(None) for _ in range(4))
    recorded = min(cpu(LiveMission()) for _ in range(4))
    seen = min(watched() for _ in range(4))
    print(f"live view, N = 100: {recorded - alone:+.3f} ms of CPU per step without a viewer")
    print(f"live view, N = 100: {seen - alone:+.3f} ms per step with one browser, server and all")


def film(run: Any, place: Path) -> None:
    def used() -> float:
        own, theirs = (
            resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
        )
        return own.ru_utime + own.ru_stime + theirs.ru_utime + theirs.ru_stime

    began = used()
    file = make_video(run, place / "film.mp4")
    took, size = used() - began, file.stat().st_size / 1e6
    frames = run.last_step + 1
    print(f"film, N = 100, {frames} frames of 1280 × 720: {took:.1f} s of CPU, {size:.1f} MB")


if __name__ == "__main__":
    sys.exit(main())
