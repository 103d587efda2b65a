// One robot's own map, where robots know different things: loaded when it is first shown, kept up to date.

import { takeBelief } from "./sources.js";

export class OwnMap {
  /** @param loaded what `loadMissions` gave; @param changed called when the view must be drawn again. */
  constructor(loaded, changed) {
    this.loaded = loaded.filter(({ mission }) => mission.facts.own_maps);
    this.changed = changed;
    this.on = false;
    this.robot = -1;
    this.button = document.getElementById("own");
    this.button.hidden = !this.loaded.length;
  }

  /** Show the selected robot's own map, or that of all robots together. */
  turn(on) {
    this.on = on && this.robot >= 0 && this.loaded.length > 0;
    this.ask();
    this.changed();
  }

  choose(robot) {
    this.robot = robot;
    if (robot < 0) this.on = false;
    this.ask();
  }

  /** Load the missing steps of the chosen map; one request at a time for each mission. */
  ask() {
    if (!this.on) return;
    const robot = this.robot;
    for (const source of this.loaded) {
      if (source.asking || robot >= source.mission.robots) continue;
      const here = source.mission.mapOf(robot)?.steps ?? 0;
      if (here >= source.mission.steps) continue;
      source.asking = true;
      takeBelief(source.mission, source.askBelief, robot)
        .then((there) => (source.missing = there ? null : robot), () => (source.missing = robot))
        .finally(() => {
          source.asking = false;
          this.changed();
          // Meanwhile another robot was chosen, or a running mission has gone on.
          if (this.robot !== robot || source.missing === null) this.ask();
        });
    }
  }

  /** Let all views show the chosen map, as far as it is loaded, and name it. */
  show() {
    this.button.disabled = this.robot < 0;
    this.button.setAttribute("aria-pressed", this.on);
    this.button.textContent = this.on ? "Show joint map" : "Show own map";
    for (const { mission, missing } of this.loaded) {
      const wanted = this.on && mission.mapOf(this.robot);
      mission.shownMap = wanted || mission.swarmMap;
      mission.mapWords = "all maps together";
      if (wanted) mission.mapWords = `the map of robot ${this.robot}`;
      else if (this.on && missing === this.robot) {
        mission.mapWords = `no own map of robot ${this.robot} in this file: all maps together`;
      } else if (this.on) mission.mapWords = `loading the map of robot ${this.robot}`;
    }
  }
}

/** Say in a view's corner whose map it shows. */
export function showMapWords(view) {
  const note = view.box.querySelector(".whose");
  if (note) note.textContent = view.mission.mapWords;
}
