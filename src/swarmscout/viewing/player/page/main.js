// Puts the page together: missions, views, panels, keys and buttons.

import { Clock, SPEEDS } from "./clock.js";
import { THEMES } from "./colours.js";
import { Curves } from "./curves.js";
import { Decisions } from "./decisions.js";
import { MapView } from "./map.js";
import { Legend } from "./legend.js";
import { hearPointer, savePicture } from "./pointer.js";
import { drawsWith, SceneView } from "./scene.js";
import { listen, loadMissions } from "./sources.js";
import { OwnMap, showMapWords } from "./ownmap.js";
import { element } from "./elements.js";
import { aboutRobot, aboutRun, stateWords } from "./describe.js";
import { teamsOf } from "./teams.js";
import { Timeline } from "./timeline.js";
import { hearKeys, readLink, writeLink } from "./keyboard.js";

const $ = (id) => document.getElementById(id);

class Player {
  constructor(loaded) {
    this.missions = loaded.map(({ mission }) => mission);
    this.mission = this.missions[0];
    this.look = { dark: true, byTeam: false, selected: -1, theme: THEMES.dark };
    this.following = false;
    this.drawn = 0; // frames, for tests and measurements
    this.clock = new Clock(() => this.refresh());
    this.clock.last = this.#last();
    const redraw = () => this.refresh();
    this.maps = this.missions.map((mission, k) => new MapView(this.#pane("maps", k, 1), mission, redraw));
    this.ownMap = new OwnMap(loaded, () => this.refresh());
    this.scenes = [];
    const means = drawsWith();
    if (means !== "none") {
      this.scenes = this.missions.map((mission, k) =>
        new SceneView(this.#pane("scenes", k, 2), mission, redraw, means === "processor"));
      this.#tieCameras();
    } else {
      document.body.classList.add("no3d");
      $("scenes").append(element("p", { class: "pane message" },
        "This browser has no WebGL2, so the 3D view is left out; map, curves and decisions are all here. " +
        "Usually WebGL2 can be switched on in the browser's settings for graphics acceleration."));
    }
    this.curves = new Curves($("curves"), this.missions, (step) => this.clock.goTo(step));
    this.decisions = new Decisions($("decisions"), $("note"), this.mission, (robot) => this.select(robot));
    this.legend = new Legend($("legend"));
    this.showLegend(window.innerWidth >= 1000 && this.missions.length < 2); // Two missions leave no room.
    this.timeline = new Timeline($("line"), this.mission, this.clock);
    for (const view of [...this.maps, ...this.scenes]) {
      hearPointer(this, view);
      view.box.addEventListener("moved", () => this.follow(false));
    }
    this.#hearButtons();
    hearKeys(this);
    loaded.forEach(({ mission, live }) => live && this.#hear(mission, live));
    if (!loaded.some(({ live }) => live)) {
      const states = this.missions.map((mission, k) => [stateWords("recorded", mission), "AB"[k]]).filter(([text]) => text);
      $("state").textContent = states.map(([text, name]) => (this.missions.length > 1 ? `${name}: ${text}` : text)).join(" · ");
    }
    document.body.classList.toggle("pair", this.missions.length > 1);
    document.title = `${this.mission.facts.name} · swarmscout`;
    $("title").textContent = this.missions.map((mission) => mission.facts.name).join(" | ");
    $("facts").textContent = aboutRun(this.mission, this.missions.length);
    this.setTheme(window.matchMedia("(prefers-color-scheme: light)").matches ? "light" : "dark");
    this.fit(false);
    this.open(readLink());
    window.addEventListener("hashchange", () => this.open(readLink()));
  }

  #pane(where, k, canvases) {
    const box = element("div", { class: "pane" });
    for (let i = 0; i < canvases; i++) box.append(element("canvas"));
    const names = this.missions.length > 1 ? `${"AB"[k]}: ${this.missions[k].facts.name}` : "";
    if (names) box.append(element("p", { class: "name" }, names));
    if (this.missions[k].facts.own_maps) box.append(element("p", { class: "whose" }));
    $(where).append(box);
    return box;
  }

  /** Two missions share one camera. */
  #tieCameras() {
    if (this.scenes.length < 2) return;
    const [a, b] = this.scenes;
    let busy = false;
    for (const [from, to] of [[a, b], [b, a]]) {
      from.controls.addEventListener("change", () => {
        if (busy) return;
        busy = true;
        to.copyCamera(from);
        busy = false;
      });
    }
  }

  #last() {
    return Math.max(...this.missions.map((mission) => mission.last));
  }

  /** Follow a mission that is still running. */
  #hear(mission, live) {
    $("live").hidden = false;
    this.clock.atEnd = true;
    this.clock.extend(this.#last());
    let due = 0;
    listen(live, mission, () => {
      this.clock.extend(this.#last());
      this.ownMap.ask();
      if (performance.now() < due) return;
      due = performance.now() + 400;
      this.curves.update();
      this.keepSwarmInView();
    }, (state) => {
      $("state").textContent = stateWords(state, mission);
      if (state === "finished") {
        $("live").hidden = true;
        this.curves.update();
        this.keepSwarmInView();
        this.refresh();
      }
    });
  }

  /** While a mission runs, zoom out as the explored part grows, unless the view was moved by hand. */
  keepSwarmInView() {
    if (this.whole || this.following) return;
    if ([...this.scenes, ...this.maps].some((view) => view.touched || view.moved)) return;
    const [left, bottom, right, top] = this.#windowOf(false);
    const [l, b, r, t] = this.fitted;
    if (left < l || bottom < b || right > r || top > t) this.fit(false);
  }

  #windowOf(whole) {
    const windows = this.missions.map((mission) => (whole ? mission.wholeWindow() : mission.seenWindow()));
    return [0, 1, 2, 3].map((i) => Math[i < 2 ? "min" : "max"](...windows.map((window) => window[i])));
  }

  #hearButtons() {
    const on = (id, what) => $(id).addEventListener("click", what);
    on("play", () => this.clock.play());
    on("back", () => this.move(-1));
    on("forth", () => this.move(1));
    on("fit", () => this.fit(!this.whole));
    on("colour", () => this.colourByTeam(!this.look.byTeam));
    on("follow", () => this.follow(!this.following));
    on("own", () => this.ownMap.turn(!this.ownMap.on));
    on("png", () => savePicture(this));
    on("theme", () => this.setTheme(this.look.dark ? "light" : "dark"));
    on("help", () => $("keys").showModal());
    on("legend-button", () => this.showLegend($("legend").hidden));
    on("enlarge", () => this.read(!this.reading));
    on("live", () => this.stayAtEnd());
    for (const button of document.querySelectorAll("nav .group button")) {
      button.addEventListener("click", () => this.setView(button.dataset.view));
    }
    for (const speed of SPEEDS) $("speed").append(element("option", { value: speed }, `${speed} steps/s`));
    $("speed").addEventListener("change", (event) => {
      this.clock.speed = Number(event.target.value);
      this.refresh();
    });
    $("pick").max = this.mission.robots - 1;
    $("pick").addEventListener("input", (event) => {
      const robot = event.target.value === "" ? -1 : Number(event.target.value);
      this.select(robot < this.mission.robots ? robot : -1, true);
    });
    $("only").addEventListener("change", () => this.refresh());
  }

  /** Show the view that a link describes. */
  open({ step, robot, view, theme, team, own }) {
    if (theme in THEMES) this.setTheme(theme);
    this.setView(["3d", "map", "both"].includes(view) ? view : document.body.dataset.view);
    if (team) this.colourByTeam(true);
    if (Number.isInteger(robot) && robot >= 0 && robot < this.mission.robots) this.select(robot);
    if (own) this.ownMap.turn(true);
    if (Number.isFinite(step)) this.clock.goTo(step);
    this.refresh();
  }

  move(steps) {
    this.clock.play(false);
    this.clock.goTo(this.clock.step + steps);
  }

  stayAtEnd() {
    this.clock.play(false);
    this.clock.atEnd = true;
    this.clock.extend(this.#last());
  }

  select(robot, typed = false) {
    this.look.selected = robot;
    this.ownMap.choose(robot);
    if (robot < 0) this.follow(false);
    if (!typed) $("pick").value = robot < 0 ? "" : robot;
    this.refresh();
  }

  follow(on) {
    this.following = on && this.look.selected >= 0;
    for (const scene of this.scenes) scene.following = false;
    $("follow").setAttribute("aria-pressed", this.following);
    $("follow").textContent = this.following ? "Stop following" : "Follow robot";
    this.refresh();
  }

  fit(whole) {
    this.whole = whole;
    $("fit").textContent = whole ? "Zoom to explored" : "Zoom to whole";
    // Two missions are shown at the same scale.
    this.fitted = this.#windowOf(whole);
    for (const view of [...this.scenes, ...this.maps]) view.fit(this.fitted);
    if (this.scenes.length > 1) {
      this.scenes[1].copyCamera(this.scenes[0]);
      this.scenes[1].touched = false;
    }
  }

  colourByTeam(on) {
    this.look.byTeam = on;
    $("colour").textContent = on ? "Colour by mode" : "Colour by team";
    this.refresh();
  }

  setView(view) {
    document.body.dataset.view = view;
    for (const button of document.querySelectorAll("nav .group button")) {
      button.setAttribute("aria-pressed", button.dataset.view === view);
    }
    this.refresh();
  }

  showLegend(on) {
    $("legend").hidden = !on;
    $("legend-button").textContent = on ? "Hide legend" : "Show legend";
    this.refresh();
  }

  /** Give the decisions half of the page, beside the map. */
  read(on) {
    this.reading = on;
    document.body.classList.toggle("reading", on);
    $("enlarge").textContent = on ? "Shrink" : "Enlarge";
    $("enlarge").setAttribute("aria-pressed", on);
    this.refresh();
  }

  setTheme(name) {
    document.documentElement.dataset.theme = name;
    this.look.dark = name === "dark";
    this.look.theme = THEMES[name];
    $("theme").textContent = name === "dark" ? "Use light" : "Use dark";
    this.curves.dress(this.look.theme);
    this.timeline.dress(this.look.theme);
    this.refresh();
  }

  /** Draw again with the next frame. */
  refresh() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame((now) => {
      this.waiting = false;
      this.clock.tick(now);
      this.draw();
      // The next callback comes when the frame is drawn: measure how long that took.
      requestAnimationFrame((later) => this.scenes.forEach((scene) => scene.keepPace(later - now)));
      if (this.clock.playing) this.refresh();
    });
  }

  /** A moment of a mission, at most its last. */
  moment(mission) {
    const time = Math.min(this.clock.time, mission.last);
    mission.seek(Math.floor(time + 1e-9));
    const robots = mission.robotsAt(time);
    return { mission, time, step: Math.floor(time + 1e-9), robots, teams: teamsOf(robots) };
  }

  draw() {
    if (!this.mission.steps) return;
    this.ownMap.show();
    const moments = this.missions.map((mission) => this.moment(mission));
    const first = (this.now = moments[0]);
    const chosen = first.robots[this.look.selected];
    if (this.following && chosen) {
      for (const view of [...this.scenes, ...this.maps]) view.follow(chosen.x, chosen.y);
    }
    moments.forEach((moment, k) => {
      this.maps[k].draw(moment, this.look);
      this.scenes[k]?.draw(moment, this.look);
    });
    for (const view of [...this.maps, ...this.scenes]) showMapWords(view);
    this.legend.update(this.look);
    this.curves.moveTo(this.clock.step);
    this.timeline.draw();
    const updated = this.decisions.update(first.step, first.robots, this.look.selected, $("only").checked);
    if (!updated) {
      clearTimeout(this.updateDue);
      this.updateDue = setTimeout(() => this.refresh(), 160);
    }
    $("follow").disabled = !chosen;
    $("about").replaceChildren(...aboutRobot(this.mission, chosen, first));
    $("live").setAttribute("aria-pressed", this.clock.atEnd);
    $("speed").value = this.clock.speed;
    $("play").setAttribute("aria-label", this.clock.playing ? "Pause" : "Play");
    $("playing").setAttribute("d", this.clock.playing ? "M3 2h4v12H3zM9 2h4v12H9z" : "M4 2.5v11l9-5.5z");
    const explored = this.mission.coverage.explored_m2?.[first.step];
    const area = explored === undefined ? "" : ` · ${Math.round(explored)} m²`;
    $("now").textContent = `step ${this.clock.step} of ${this.clock.last}${area}`;
    writeLink(this);
    this.drawn++;
    document.body.dataset.ready = "yes";
  }
}

try {
  window.player = new Player(await loadMissions());
} catch (error) {
  $("sorry").hidden = false;
  $("sorry").textContent = `The mission cannot be shown: ${error.message}`;
  throw error;
}
