// Keys, and links to a step.

import { savePicture } from "./pointer.js";

/** The view that the page's address describes: `#t=150&robot=3&view=map&theme=light`. */
export function readLink() {
  const asked = new URLSearchParams(window.location.hash.slice(1));
  const number = (name) => (asked.has(name) ? Number(asked.get(name)) : undefined);
  return {
    step: number("t"), robot: number("robot"), view: asked.get("view"), theme: asked.get("theme"),
    team: asked.get("colour") === "team", own: asked.get("map") === "own",
  };
}

/** Keep the address up to date, so that it can be copied; not while playing. */
export function writeLink(player) {
  if (player.clock.playing || player.clock.atEnd) return;
  const words = new URLSearchParams({ t: player.clock.step });
  if (player.look.selected >= 0) words.set("robot", player.look.selected);
  if (document.body.dataset.view !== "3d") words.set("view", document.body.dataset.view);
  if (player.look.byTeam) words.set("colour", "team");
  if (player.ownMap.on) words.set("map", "own");
  const hash = `#${words}`;
  if (hash === window.location.hash) return;
  clearTimeout(player.linkDue);
  player.linkDue = setTimeout(() => window.history.replaceState(null, "", hash), 150);
}

export function hearKeys(player) {
  const next = (by) => {
    const n = player.mission.robots;
    player.select((player.look.selected + by + n + (player.look.selected < 0 && by < 0 ? 1 : 0)) % n);
  };
  const actions = {
    " ": () => player.clock.play(),
    ArrowLeft: (event) => player.move(event.shiftKey ? -10 : -1),
    ArrowRight: (event) => player.move(event.shiftKey ? 10 : 1),
    Home: () => player.move(-Infinity),
    End: () => player.move(Infinity),
    "+": () => player.clock.faster(1),
    "=": () => player.clock.faster(1),
    "-": () => player.clock.faster(-1),
    1: () => player.setView("3d"),
    2: () => player.setView("map"),
    3: () => player.setView("both"),
    z: () => player.fit(!player.whole),
    n: () => next(1),
    N: () => next(-1),
    f: () => player.follow(!player.following),
    c: () => player.colourByTeam(!player.look.byTeam),
    o: () => player.ownMap.turn(!player.ownMap.on),
    t: () => player.setTheme(player.look.dark ? "light" : "dark"),
    p: () => savePicture(player),
    l: () => document.getElementById("live").hidden || player.stayAtEnd(),
    k: () => player.showLegend(document.getElementById("legend").hidden),
    d: () => player.read(!player.reading),
    "?": () => document.getElementById("keys").showModal(),
    Escape: () => (player.reading ? player.read(false) : player.select(-1)),
  };
  window.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]")) return;
    const within = event.target;
    if (within instanceof HTMLInputElement && within.type === "number") return;
    if (within instanceof HTMLSelectElement) return;
    // A focused button or box takes the space bar itself.
    if (event.key === " " && (within instanceof HTMLButtonElement || within.type === "checkbox")) return;
    const action = actions[event.key];
    if (!action) return;
    event.preventDefault();
    action(event);
  });
}
