// One robot's own map, where robots know different things: asked for when it is first wanted, kept up to date.

import { takeBelief } from "./sources.js";

export class OwnMap {
  /** @param loaded what `loadMissions` gave; @param changed called when another map is to be seen. */
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

  /** Ask for what is missing of the map that is wanted; one question at a time for each mission. */
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

  /** Put the wanted map, as far as it is here, in front of all views, and say whose it is. */
  show() {
    this.button.disabled = this.robot < 0;
    this.button.setAttribute("aria-pressed", this.on);
    for (const { mission, missing } of this.loaded) {
      const wanted = this.on && mission.mapOf(this.robot);
      mission.shownMap = wanted || mission.swarmMap;
      mission.toldMap = "all robots' maps together";
      if (wanted) mission.toldMap = `what robot ${this.robot} knows`;
      else if (this.on && missing === this.robot) {
        mission.toldMap = `robot ${this.robot}'s own map is not here: all robots' maps together`;
      } else if (this.on) mission.toldMap = `robot ${this.robot}'s own map is on its way`;
    }
  }
}

/** Say in a view's corner whose map it shows. */
export function tellWhose(view) {
  const told = view.box.querySelector(".whose");
  if (told) told.textContent = view.mission.toldMap;
}
