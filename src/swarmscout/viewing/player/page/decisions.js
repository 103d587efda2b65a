// The decisions: which leader chose which cell, and why. Selectors and language models write these texts:
// they are put on the page as text, never as markup.

import { element } from "./elements.js";

const SHOWN = 40;
const PAUSE_MS = 150; // While the step changes fast, the list need not follow every frame.
/** Columns that a row's first lines show already. */
const HEADLINE = new Set(["step", "leader", "cause", "selector", "reason", "cell", "x_m", "y_m", "team", "attempts"]);

export class Decisions {
  /** @param choose called with the leader of an opened decision. */
  constructor(list, note, mission, choose) {
    this.list = list;
    this.note = note;
    this.mission = mission;
    this.choose = choose;
    this.open = new Set(); // rows that are unfolded
    this.items = new Map(); // elements by row
    this.current = null; // the row that the tab key reaches
    list.addEventListener("keydown", (event) => this.#hear(event));
    this.shown = "";
    this.due = 0;
  }

  /**
   * Show the decisions up to a step, newest first; of one robot's team only if one is selected.
   * Returns false if it was too soon for that: ask again.
   */
  update(step, robots, selected, onlySelected) {
    const all = this.mission.decisions;
    const end = countUpTo(all, step);
    const leader = onlySelected && robots[selected] ? robots[selected].leader : null;
    const key = `${end} ${leader} ${selected} ${this.open.size}`;
    if (key === this.shown) return true;
    if (performance.now() < this.due) return false;
    this.due = performance.now() + PAUSE_MS;
    this.shown = key;
    const rows = [];
    for (let i = end - 1; i >= 0 && rows.length < SHOWN; i--) {
      if (leader === null || all[i].leader === leader || all[i].leader === selected) rows.push(i);
    }
    this.note.textContent = rows.length
      ? `${end} so far${leader === null ? "" : `, those of robots ${[...new Set([leader, selected])].join(" and ")}`}`
      : "none yet";
    this.#arrange(rows);
    return true;
  }

  /** Put rows into the list; those that are there already stay as they are, with focus and scroll position. */
  #arrange(rows) {
    const kept = new Map(rows.map((i) => [i, this.items.get(i) ?? this.#row(i)]));
    for (const [i, item] of this.items) if (!kept.has(i)) item.remove();
    this.items = kept;
    let at = this.list.firstChild;
    for (const item of kept.values()) {
      if (item === at) at = at.nextSibling;
      else this.list.insertBefore(item, at);
    }
    this.#aimTab();
  }

  /** One decision is reached with the tab key, the others from there with the arrow keys. */
  #aimTab() {
    if (!this.items.has(this.current)) this.current = this.items.keys().next().value ?? null;
    for (const [i, item] of this.items) item.firstChild.tabIndex = i === this.current ? 0 : -1;
  }

  #hear(event) {
    if (!event.target.classList.contains("decision")) return;
    const way = { ArrowDown: "nextSibling", ArrowUp: "previousSibling" }[event.key];
    const next = way && event.target.parentElement[way];
    if (!next) return;
    event.preventDefault();
    this.current = [...this.items].find(([, item]) => item === next)[0];
    this.#aimTab();
    next.firstChild.focus();
  }

  #row(i) {
    const row = this.mission.decisions[i];
    const item = element("li");
    const head = element("button", { type: "button", class: "decision" });
    head.setAttribute("aria-expanded", this.open.has(i));
    const where = row.cell == null ? "nothing to choose" : `→ ${number(row.x_m)}, ${number(row.y_m)} m`;
    head.append(
      element("span", { class: "when" }, `${row.step}`),
      element("span", { class: "who" }, `robot ${row.leader}`),
      element("span", { class: "where" }, where),
      element("span", { class: "why" }, cut(`${row.cause}${row.reason ? ` · ${row.reason}` : ""}`, 160)),
    );
    head.addEventListener("click", () => {
      if (this.open.has(i)) this.open.delete(i);
      else this.open.add(i);
      this.due = 0;
      this.current = i;
      this.choose(row.leader);
      const anew = this.#row(i);
      this.items.set(i, anew);
      item.replaceWith(anew);
      this.#aimTab();
      anew.firstChild.focus();
      if (this.open.has(i)) anew.scrollIntoView({ block: "nearest" });
    });
    item.append(head);
    if (this.open.has(i)) item.append(details(row));
    return item;
  }
}

/** How many rows, in order of steps, belong to a step or an earlier one. */
function countUpTo(rows, step) {
  let [low, high] = [0, rows.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (rows[middle].step <= step) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** All columns of a decision: the well-known first, then the others. */
function details(row) {
  const list = element("dl");
  if (row.reason) put(list, "reason", row.reason);
  put(list, "attempts", row.attempts);
  put(list, "cause", row.cause);
  put(list, "selector", row.selector);
  for (const [name, value] of Object.entries(row)) {
    if (!HEADLINE.has(name) && name !== "details") put(list, name.replaceAll("_", " "), value);
  }
  const more = row.details;
  if (more && typeof more === "object") {
    for (const [name, value] of Object.entries(more)) put(list, name.replaceAll("_", " "), value);
  } else if (more && more !== "{}") put(list, "details", more);
  return list;
}

function put(list, name, value) {
  if (value === null || value === undefined || value === "") return;
  list.append(element("dt", {}, name));
  const shown = element("dd");
  if (Array.isArray(value) && value.length && value.every((inner) => inner && typeof inner === "object")) {
    // Attempts and the like: one group of facts after the other, the last one open.
    value.forEach((inner, i) => {
      const group = element("details");
      group.open = i === value.length - 1;
      group.append(element("summary", {}, `${i + 1} of ${value.length}`));
      const { prompt, answer, ...others } = inner;
      const facts = element("dl");
      for (const [key, fact] of Object.entries(others)) put(facts, key.replaceAll("_", " "), fact);
      const exchange = element("div", { class: "exchange" });
      for (const [key, text] of Object.entries({ prompt, answer })) {
        if (!text) continue;
        const part = element("section", { "aria-label": key });
        part.append(element("h3", {}, key), element("pre", { tabindex: "0" }, text));
        exchange.append(part);
      }
      group.append(exchange, facts);
      shown.append(group);
    });
    shown.classList.add("wide");
  } else {
    const text = typeof value === "number" ? number(value) : typeof value === "string" ? value : JSON.stringify(value);
    const long = text.length > 120 || text.includes("\n");
    shown.append(long ? element("pre", { tabindex: "0" }, text) : text);
  }
  list.append(shown);
}

export function number(value) {
  if (typeof value !== "number") return String(value);
  return Number.isInteger(value) ? String(value) : value.toFixed(2);
}

function cut(text, longest) {
  return text.length > longest ? `${text.slice(0, longest)} …` : text;
}
