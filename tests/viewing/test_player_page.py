"""The page in a real browser: what it shows is what the run holds."""

from __future__ import annotations

import json
import re

import numpy as np
import polars as pl
import pytest
from PIL import Image

from swarmscout import Run
from swarmscout.viewing.map_image import frontier_cells, labels_at
from swarmscout.viewing.palette import DARK, LIGHT, rgb
from swarmscout.viewing.player.page import one_file
from swarmscout.viewing.player.recorded import player_data
from swarmscout.viewing.player.server import PlayerServer, Recorded

PIXELS = """(selector) => {
    const canvas = document.querySelector(selector);
    player.draw();
    const copy = document.createElement("canvas");
    copy.width = canvas.width; copy.height = canvas.height;
    const ctx = copy.getContext("2d");
    ctx.drawImage(canvas, 0, 0);
    const pixels = ctx.getImageData(0, 0, copy.width, copy.height).data;
    let sum = 0;
    for (let i = 0; i < pixels.length; i++) sum += pixels[i] * (1 + (i % 977));
    return sum;
}"""
MAP, SCENE = "#maps canvas", "#scenes canvas"
CURSOR = """() => {
    const cursor = document.querySelector("#curves .cursor").getBoundingClientRect();
    const chart = document.querySelector("#curves .u-over").getBoundingClientRect();
    const text = document.querySelector("#curves output").textContent;
    return [(cursor.left + 0.5 - chart.left) / chart.width, text];
}"""


@pytest.fixture(scope="module")
def file(data, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "mission.html"
    path.write_bytes(one_file("<b>a & b</b>", [data]))
    return path


def test_a_file_shows_what_the_run_holds(file, run, watched):
    seen = watched()
    page = seen.open(f"{file.as_uri()}#t=30&robot=5")
    assert page.title() == "seen · swarmscout"
    assert page.evaluate("[player.clock.step, player.look.selected]") == [30, 5]

    # On a slow machine the view takes fewer pixels after a while, which is not what is tested here.
    page.evaluate("player.scenes[0].keepPace = () => {}")

    pictures = {}
    for step in (0, 30, run.last_step):
        page.evaluate(f"player.clock.goTo({step}); player.draw()")
        rows = run.steps.filter(pl.col("step") == step)
        true = rows.select("x_m", "y_m").to_numpy()
        shown = np.array(page.evaluate("player.scenes[0].shownPositions()"))
        assert np.abs(shown - true).max() < 0.0006  # millimetres
        robots = page.evaluate("player.now.robots")
        assert [robot["charging"] for robot in robots] == (rows["mode"] == "CHR").to_list()
        assert [robot["alive"] for robot in robots] == rows["alive"].to_list()
        assert [robot["leader"] for robot in robots] == rows["leader"].to_list()
        assert [robot["destination"] for robot in robots] == rows["destination"].to_list()
        teams = page.evaluate("player.now.robots.map((robot) => player.mission.teams[robot.team])")
        assert teams == rows["team"].to_list()
        turns = np.array([robot["heading"] for robot in robots]) - rows["heading_rad"].to_numpy()
        assert np.abs(np.angle(np.exp(1j * turns))).max() < 1e-9
        labels = np.array(page.evaluate("[...player.mission.labels]")).reshape(run.frame.shape)
        assert (labels == labels_at(run, step)).all()
        edge = np.array(page.evaluate("[...player.maps[0].frontier]")).reshape(run.frame.shape)
        assert (edge.astype(bool) == frontier_cells(labels_at(run, step))).all()
        pictures[step] = [page.evaluate(PIXELS, name) for name in (MAP, SCENE)]
        x, text = page.evaluate(CURSOR)
        assert x == pytest.approx(step / run.last_step, abs=0.005)
        assert text == str(round(run.coverage["explored_m2"][step]))
    assert page.evaluate(PIXELS, "#curves canvas") > 0
    # What is inside the canvases changes when one scrubs, and comes back.
    for a, b in ((0, 30), (30, run.last_step)):
        assert all(x != y for x, y in zip(pictures[a], pictures[b], strict=True))
    page.evaluate("player.clock.goTo(30); player.draw()")
    assert [page.evaluate(PIXELS, name) for name in (MAP, SCENE)] == pictures[30]
    assert page.evaluate("player.mission.decisions.length") == run.decisions.height
    assert seen.troubles == []
    assert seen.requests == [
        url for url in seen.requests if url.startswith((file.as_uri(), "blob:", "data:"))
    ]


def test_keys_buttons_and_links(file, run, watched):
    seen = watched()
    page = seen.open(f"{file.as_uri()}#t=10")
    step = "player.clock.step"
    for key, expected in (
        ("ArrowRight", 11), ("Shift+ArrowRight", 21), ("ArrowLeft", 20),
        ("Home", 0), ("ArrowLeft", 0), ("End", run.last_step), ("ArrowRight", run.last_step),
    ):  # fmt: skip
        page.keyboard.press(key)
        assert page.evaluate(step) == expected
    seen.until(f"location.hash === '#t={run.last_step}'")
    page.evaluate("location.hash = '#t=25&view=map&colour=team'")
    seen.until(f"{step} === 25 && document.body.dataset.view === 'map'")
    assert page.evaluate("player.look.byTeam")

    page.keyboard.press("n")
    page.keyboard.press("n")
    assert page.evaluate("player.look.selected") == 1
    page.keyboard.press("f")
    assert page.evaluate("player.following")
    assert "robot" in page.inner_text("#panel").lower()
    page.keyboard.press("Escape")
    assert page.evaluate("[player.look.selected, player.following]") == [-1, False]

    before = page.evaluate("document.documentElement.dataset.theme")
    page.keyboard.press("t")
    assert page.evaluate("document.documentElement.dataset.theme") != before
    page.keyboard.press("Shift+?")
    assert page.is_visible("#keys")
    page.keyboard.press("Escape")
    assert not page.is_visible("#keys")

    for key in ("+", "-", "-", "-"):
        page.keyboard.press(key)
    assert page.evaluate("player.clock.speed") == 2  # So slow that the end is far away.
    # The page is drawn by its own clock: 40 frames of 50 ms at 2 steps a second are 4 steps.
    page.evaluate("player.refresh = () => {}")
    # A frame that was asked for before still comes, with the browser's time.
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    page.keyboard.press("Space")
    assert page.evaluate("player.clock.playing")
    for frame in range(41):
        page.evaluate(f"player.clock.tick({50 * frame}); player.draw()")
    assert page.evaluate("player.clock.time") == pytest.approx(29.0)
    page.evaluate("player.clock.tick(2025)")
    assert page.evaluate("player.clock.time") == pytest.approx(29.05)
    page.keyboard.press("Space")
    stopped = page.evaluate("player.clock.time")
    assert stopped == 29
    with page.expect_download() as saved:
        page.keyboard.press("p")
    assert saved.value.suggested_filename == f"seen-step-{int(stopped)}.png"
    assert saved.value.path().read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


def test_pointing_at_a_robot_tells_and_selects(file, run, watched):
    page = watched().open(f"{file.as_uri()}#t=40&view=map")
    x, y = page.evaluate("""() => {
        const robot = player.now.robots[3];
        const [px, py] = player.maps[0].toPixels(robot.x, robot.y);
        const box = document.querySelector("#maps canvas").getBoundingClientRect();
        return [box.left + px, box.top + py];
    }""")
    page.mouse.move(x, y)
    near = page.inner_text("#tip")
    assert re.match(r"robot \d+ · (EXP|CHR) · charge \d+ %", near)
    page.mouse.click(x, y)
    assert page.evaluate("player.look.selected") == int(near.split()[1])


def test_a_server_shows_two_missions_in_step(data, watched):
    with PlayerServer([Recorded(data), Recorded(data)], port=0) as server:
        seen = watched()
        page = seen.open(f"{server.url}#t=20")
        page.evaluate("player.clock.goTo(33); player.draw()")
        steps = page.evaluate("player.missions.map((mission) => mission.shownMap.step)")
        assert steps == [33, 33]
        one, other = page.evaluate("player.scenes.map((scene) => scene.shownPositions())")
        assert one == other
        assert page.locator(".pane").count() == 4
        assert seen.troubles == []
        assert seen.foreign == []


def test_without_webgl2_the_rest_still_works(file, watched):
    seen = watched()
    seen.page.add_init_script("""
        const get = HTMLCanvasElement.prototype.getContext;
        HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
            return kind === "webgl2" ? null : get.call(this, kind, ...more);
        };
    """)
    page = seen.open(f"{file.as_uri()}#t=20")
    assert "no WebGL2" in page.inner_text("#scenes")
    before = page.evaluate(PIXELS, MAP)
    page.keyboard.press("End")
    assert page.evaluate(PIXELS, MAP) != before
    assert seen.troubles == []


COMPARE = """(step) => {
    const scene = player.scenes[0];
    const pixels = (kept) => {
        scene.still.picture.visible = kept;
        scene.terrain.mesh.visible = !kept;
        player.draw();
        const copy = document.createElement("canvas");
        copy.width = scene.canvas.width; copy.height = scene.canvas.height;
        const ctx = copy.getContext("2d");
        ctx.drawImage(scene.canvas, 0, 0);
        return ctx.getImageData(0, 0, copy.width, copy.height).data;
    };
    const difference = (a, b) => {
        let [sum, far] = [0, 0];
        for (let i = 0; i < a.length; i++) {
            sum += Math.abs(a[i] - b[i]);
            far += Math.abs(a[i] - b[i]) > 20;
        }
        return [sum / a.length, far / a.length];
    };
    player.clock.goTo(step);
    const [anew, kept] = [pixels(false), pixels(true)];
    const since = window.before ? difference(kept, window.before)[0] : 0;
    window.before = kept;
    return [...difference(kept, anew), since, scene.redrawn];
}"""


def test_the_kept_picture_of_the_rock_is_the_rock(file, watched):
    """Without a graphics card the rock is drawn once for all steps: it looks as if drawn anew."""
    page = watched(width=640, height=480).open(f"{file.as_uri()}#t=20")
    assert page.evaluate("!!player.scenes[0].still"), "this Chromium draws in software"
    page.evaluate("player.scenes[0].keepPace = () => {}")
    for step, change, least in (
        (20, "", 0.0),
        (60, "", 1.0),  # More is known.
        (60, "player.scenes[0].follow(12, 25)", 3.0),
        (60, "player.setTheme(player.look.dark ? 'light' : 'dark')", 3.0),
    ):
        page.evaluate(change)
        page.evaluate("player.draw()")
        mean, far, since, redrawn = page.evaluate(COMPARE, step)
        assert mean < 1.0
        assert far < 0.003
        assert since >= least
        assert not redrawn  # The last drawing put light on a picture that was there.


STANDING = """() => {
    const { robots, mission } = player.scenes[0];
    robots.place(player.now.robots, player.look, 1000, 1, 1);  // From near by: bodies, not dots.
    return player.now.robots.map((robot) => [
        [...robots.bodies.instanceMatrix.array.slice(16 * robot.robot, 16 * robot.robot + 16)],
        robot.x, robot.y, robot.heading, ...mission.riseAt(robot.x, robot.y),
    ]);
}"""


def test_bodies_stand_on_the_floor_as_it_slopes(file, run, watched):
    page = watched(width=640, height=480).open(f"{file.as_uri()}#t=40")
    standing = page.evaluate(STANDING)
    assert len(standing) == run.scenario.robots
    tilts = []
    for matrix, x, y, heading, rise_x, rise_y in standing:
        ahead, left, up, place = np.array(matrix).reshape(4, 4)[:, :3]
        radius = run.scenario.body.radius_m
        turned = np.array([ahead, left, up]) / radius
        np.testing.assert_allclose(turned @ turned.T, np.eye(3), atol=1e-5)
        np.testing.assert_allclose(place[:2], [x, y], atol=1e-5)
        normal = np.array([-rise_x, -rise_y, 1.0])
        np.testing.assert_allclose(turned[2], normal / np.linalg.norm(normal), atol=1e-5)
        np.testing.assert_allclose(np.cross(turned[0], turned[1]), turned[2], atol=1e-5)
        assert np.cos(np.arctan2(ahead[1], ahead[0]) - heading) == pytest.approx(1.0, abs=1e-6)
        tilts.append(np.degrees(np.arccos(turned[2, 2])))
    assert 0.5 < max(tilts) < 45.0


HOSTILE = [
    "<img src=x onerror=alert(1)>",
    "</script><script>window.stolen = 1</script>",
    "<script src=https://example.org/x.js></script>",
    "\x00\x01\x07\x1b[31m\u202e\ufeff\ud7ff end",
    "javascript:alert(1)",
    "x" * 1_000_000,
]


def test_hostile_words_do_no_harm(run, watched, tmp_path):
    first = run.decisions.row(0, named=True)
    rows = [
        first
        | {"step": 10 + i, "reason": text, "selector": text}
        | {"details": json.dumps({"answer": text, "tries": [{"prompt": text, "valid": False}]})}
        for i, text in enumerate(HOSTILE)
    ]
    changed = Run.open(run.path)
    changed._frames["decisions"] = pl.DataFrame(rows, schema=run.decisions.schema)
    file = tmp_path / "hostile.html"
    file.write_bytes(one_file("</title><script>window.stolen = 1</script>", [player_data(changed)]))
    assert file.stat().st_size < 2_000_000

    seen = watched()
    seen.page.on("dialog", lambda dialog: seen.troubles.append("dialog"))
    page = seen.open(f"{file.as_uri()}#t=50")
    for button in page.locator(".decision").all():
        button.click()
    for summary in page.locator("#decisions summary").all():
        summary.click()
    text = page.inner_text("#decisions")
    assert "<img src=x onerror=alert(1)>" in text
    assert "1,000,000 characters, cut" in text
    assert page.locator("#decisions img, #decisions script").count() == 0
    assert page.evaluate("window.stolen") is None
    assert not re.search("[\x00-\x08\x1b\u202e]", text)
    assert seen.troubles == []
    assert seen.foreign == []


def test_north_is_up_in_both_views_and_both_say_so(file, watched):
    page = watched().open(f"{file.as_uri()}#t=40&view=both")
    places = """(view) => {
        const [left, bottom, right, top] = view.window;
        const [x, y] = [(left + right) / 2, (bottom + top) / 2];
        return [[x, y], [x + 2, y], [x, y + 2]].map(([a, b]) => view.toPixels(a, b));
    }"""
    for view in ("player.scenes[0]", "player.maps[0]"):
        middle, east, north = np.array(page.evaluate(f"({places})({view})"))
        assert east[0] > middle[0] + 5
        assert east[1] == pytest.approx(middle[1], abs=3)  # The ground slopes a little.
        assert north[1] < middle[1] - 5
        assert north[0] == pytest.approx(middle[0], abs=3)
    page.evaluate("player.scenes[0].camera.position.x += 30; player.scenes[0].controls.update()")
    middle, _, north = np.array(page.evaluate(f"({places})(player.scenes[0])"))
    assert north[0] > middle[0] + 3  # Seen from the south-east, north is to the right.


def test_the_legend_explains_what_is_drawn_and_can_be_hidden(file, watched, tmp_path):
    page = watched().open(f"{file.as_uri()}#t=40&view=map")
    text = page.inner_text("#legend")
    for sign in ("EXP", "CHR", "stranded", "leader", "destination", "station", "unknown", "free",
                 "wall", "frontier", "time line"):  # fmt: skip
        assert sign in text
    assert "route" not in text  # No robot is selected.
    page.keyboard.press("n")
    page.keyboard.press("c")
    page.evaluate("player.draw()")
    assert "route" in page.inner_text("#legend")
    assert "team's colour" in page.inner_text("#legend")
    assert page.evaluate("""() => [...document.querySelectorAll("#legend canvas")].every((sign) =>
        sign.getContext("2d").getImageData(0, 0, sign.width, sign.height).data.some((x) => x))""")
    assert page.inner_text("#legend-button") == "Hide legend"
    page.keyboard.press("k")
    assert not page.is_visible("#legend")
    assert page.inner_text("#legend-button") == "Show legend"


def test_a_saved_picture_has_legend_and_scale(file, watched, tmp_path):
    page = watched().open(f"{file.as_uri()}#t=40&view=map&theme=light")
    with page.expect_download() as saved:
        page.click("#png")
    saved.value.save_as(tmp_path / "view.png")
    with Image.open(tmp_path / "view.png") as picture:
        pixels = np.asarray(picture.convert("RGB"))
    width, height = page.evaluate("[player.maps[0].sheet.width, player.maps[0].sheet.height]")
    assert pixels.shape[1] == width
    assert pixels.shape[0] > height + 60
    below = pixels[height + 30 :].reshape(-1, 3)
    for colour in (LIGHT.explore, LIGHT.frontier, LIGHT.unknown, LIGHT.destination):
        assert (below == rgb(colour)).all(axis=1).any(), colour


def test_the_map_follows_the_theme(file, watched):
    page = watched().open(f"{file.as_uri()}#t=40&view=map")
    corner = """() => {
        player.draw();
        const { canvas } = player.maps[0].sheet;
        const pixel = canvas.getContext("2d").getImageData(canvas.width / 2, 3, 1, 1).data;
        return [...pixel].slice(0, 3);
    }"""
    for theme, palette in (("dark", DARK), ("light", LIGHT)):
        page.evaluate(f"player.setTheme('{theme}')")
        assert tuple(page.evaluate(corner)) == rgb(palette.unknown)
        background = page.evaluate("getComputedStyle(document.body).backgroundColor")
        assert background == f"rgb{rgb(palette.background)}"


def test_button_labels_name_actions(file, watched):
    page = watched().open(f"{file.as_uri()}#t=40")
    verbs = ("Show ", "Hide ", "Zoom ", "Colour ", "Follow ", "Stop ", "Save ", "Use ", "Enlarge",
             "Shrink", "Go ", "Close ", "Play", "Pause", "Step ")  # fmt: skip
    for key in ("", "n", "f", "c", "z", "t", "k", "d", "Space"):
        if key:
            page.keyboard.press(key)
            page.evaluate("player.draw()")
        names = page.evaluate("""() => [...document.querySelectorAll("button:not(.decision)")].map(
            (button) => button.getAttribute("aria-label") ?? button.textContent)""")
        assert len(names) > 12
        assert [name for name in names if not name.startswith(verbs)] == []


def test_the_tab_key_reaches_everything_and_the_list_once(file, watched):
    page = watched().open(f"{file.as_uri()}#t=60")
    where = """() => {
        const { id, className, tagName } = document.activeElement;
        return id || className || tagName;
    }"""
    order = []
    for _ in range(40):
        page.keyboard.press("Tab")
        order.append(page.evaluate(where))
        if order[-1] == "speed":
            break
    assert order[-1] == "speed"
    assert order.count("decision") == 1
    for one, later in zip(
        ("fit", "legend-button", "help", "pick", "enlarge", "decision", "back", "play", "scrub"),
        ("legend-button", "help", "pick", "enlarge", "decision", "back", "play", "scrub", "speed"),
        strict=True,
    ):
        assert order.index(one) < order.index(later)
    page.focus(".decision[tabindex='0']")
    first = page.evaluate("document.activeElement.textContent")
    page.keyboard.press("ArrowDown")
    second = page.evaluate("document.activeElement.textContent")
    assert first != second
    page.keyboard.press("Enter")  # It opens, and the focus stays.
    assert page.evaluate("document.activeElement.getAttribute('aria-expanded')") == "true"
    page.keyboard.press("ArrowUp")
    assert page.evaluate("document.activeElement.textContent") == first


def test_a_long_prompt_and_answer_are_read_beside_the_map(run, watched, tmp_path):
    prompt, answer = "p" * 5000 + " end of prompt", "\n".join(f"line {k}" for k in range(700))
    row = run.decisions.row(0, named=True) | {"step": 10, "reason": "because"}
    row["details"] = json.dumps({"attempts": [{"prompt": prompt, "answer": answer}]})
    changed = Run.open(run.path)
    changed._frames["decisions"] = pl.DataFrame([row], schema=run.decisions.schema)
    file = tmp_path / "long.html"
    file.write_bytes(one_file("long", [player_data(changed)]))
    page = watched(width=1280, height=720).open(f"{file.as_uri()}#t=50&view=map")
    page.click(".decision")
    page.click("#enlarge")
    asked, answered = page.locator(".exchange pre").all()
    assert asked.inner_text().endswith("end of prompt")
    assert answered.inner_text().endswith("line 699")
    one, other = asked.bounding_box(), answered.bounding_box()
    assert one["y"] == other["y"]
    assert one["x"] + one["width"] <= other["x"]
    panel, chart = (page.locator(name).bounding_box() for name in ("#panel", "#maps"))
    assert panel["width"] > 600
    assert chart["width"] > 400
    assert chart["x"] + chart["width"] <= panel["x"]
    assert one["height"] > 250
    page.keyboard.press("Escape")
    assert page.inner_text("#enlarge") == "Enlarge"
