// A mission's data: every robot at every step, the map at any step, decisions, events, curves.

import { MapHistory, NEVER, roomFor } from "./history.js";

const MARGIN_M = 2.5; // shown round what was mapped

export class Mission {
  /** @param packet the mission packet: facts, relief, free raster. */
  constructor({ facts, arrays }) {
    this.facts = facts;
    this.robots = facts.robots;
    this.frame = facts.frame;
    this.steps = 0; // how many steps are here, step 0 included
    this.columns = {}; // whole numbers per robot and step, as blocks.py describes them
    this.teams = []; // team ids, in the order of their numbers in columns.team
    this.teamNumbers = new Map();
    this.decisions = [];
    this.events = { step: [], kind: [], robot: [], other: [], value: [] };
    this.coverage = {};
    this.relief = readRelief(facts.relief, arrays);
    this.raster = { ...facts.raster, free: arrays.free };

    this.swarmMap = new MapHistory(facts);
    this.beliefs = new Map(); // maps of single robots, as far as they were requested
    this.shownMap = this.swarmMap; // the map that views show, at the step of `seek`
  }

  get last() {
    return Math.max(0, this.steps - 1);
  }

  /** Add a range of steps, if it follows on the last step that is here. Returns whether it was added. */
  append({ facts, arrays }) {
    if (facts.first !== this.steps || !facts.steps) return false;
    const n = this.robots;
    const begin = facts.first * n;
    const end = begin + facts.steps * n;
    for (const name of facts.columns) {
      const column = (this.columns[name] = roomFor(this.columns[name] ?? new Int32Array(0), end));
      const first = arrays[`${name}.first`];
      const rest = arrays[`${name}.rest`];
      column.set(first, begin);
      for (let i = 0, at = begin + n; at < end; i++, at++) column[at] = column[at - n] + rest[i];
    }
    this.#renumberTeams(facts.teams, begin, end);
    this.swarmMap.append(facts, arrays);
    for (const row of facts.decisions) this.decisions.push(row);
    for (const name of Object.keys(this.events)) {
      for (const value of arrays[`events.${name}`]) this.events[name].push(value);
    }
    for (const name of facts.coverage) {
      const values = (this.coverage[name] ??= []);
      for (const value of arrays[`coverage.${name}`]) values.push(value);
    }
    this.steps += facts.steps;
    return true;
  }

  #renumberTeams(ids, begin, end) {
    const numbers = ids.map((id) => {
      if (!this.teamNumbers.has(id)) {
        this.teamNumbers.set(id, this.teams.length);
        this.teams.push(id);
      }
      return this.teamNumbers.get(id);
    });
    const team = this.columns.team;
    for (let i = begin; i < end; i++) team[i] = numbers[team[i]];
  }

  /** The map of one robot, if it is here; without `robot` that of all robots together. */
  mapOf(robot) {
    return robot < 0 ? this.swarmMap : this.beliefs.get(robot) ?? null;
  }

  /** Bring the map that is shown to a step. */
  seek(step) {
    this.shownMap.seek(Math.min(step, this.shownMap.steps - 1));
  }

  get labels() {
    return this.shownMap.labels;
  }

  get logOdds() {
    return this.shownMap.logOdds;
  }

  /** A robot at a moment, between two steps too. Positions in metres, heading in radians. */
  robotAt(robot, time) {
    const step = Math.min(Math.floor(time), this.last);
    const share = step < this.last ? time - step : 0;
    const a = step * this.robots + robot;
    const b = share > 0 ? a + this.robots : a;
    const c = this.columns;
    let turn = c.heading_rad[b] - c.heading_rad[a];
    turn -= 3600 * Math.round(turn / 3600);
    return {
      robot,
      x: (c.x_m[a] + (c.x_m[b] - c.x_m[a]) * share) / 1000,
      y: (c.y_m[a] + (c.y_m[b] - c.y_m[a]) * share) / 1000,
      heading: ((c.heading_rad[a] + turn * share) * Math.PI) / 1800,
      charge: c.charge[a] / 1000,
      charging: c.mode[a] === 1,
      action: c.action[a],
      contact: c.contact[a],
      alive: c.alive[a] === 1,
      team: c.team[a],
      leader: c.leader[a],
      desired: c.desired[a],
      destination: c.destination[a],
    };
  }

  /** All robots at a moment. */
  robotsAt(time) {
    return Array.from({ length: this.robots }, (_, robot) => this.robotAt(robot, time));
  }

  /** Centre of a map cell in metres. */
  centre(cell) {
    const f = this.frame;
    const row = Math.floor(cell / f.columns);
    return [f.x_m + (cell - row * f.columns + 0.5) * f.cell_m, f.y_m + (row + 0.5) * f.cell_m];
  }

  /** Flat map cell at a point in metres, or -1 outside. */
  cellAt(x, y) {
    const f = this.frame;
    const row = Math.floor((y - f.y_m) / f.cell_m);
    const col = Math.floor((x - f.x_m) / f.cell_m);
    return row < 0 || col < 0 || row >= f.rows || col >= f.columns ? -1 : row * f.columns + col;
  }

  /** Whether a point lies in free space of the world. */
  isFree(x, y) {
    const f = this.raster;
    const row = Math.floor((y - f.y_m) / f.cell_m);
    const col = Math.floor((x - f.x_m) / f.cell_m);
    if (row < 0 || col < 0 || row >= f.rows || col >= f.columns) return false;
    const bit = row * f.columns + col;
    return ((f.free[bit >> 3] >> (7 - (bit & 7))) & 1) === 1;
  }

  /** Height of the floor at a point, in metres. */
  groundAt(x, y) {
    const r = this.relief;
    const col = Math.min(r.columns - 1, Math.max(0, Math.floor((x - r.x_m) / r.cell_m)));
    const row = Math.min(r.rows - 1, Math.max(0, Math.floor((y - r.y_m) / r.cell_m)));
    return r.ground[row * r.columns + col];
  }

  /** How much the floor rises per metre along x and along y at a point. */
  riseAt(x, y) {
    const d = this.relief.cell_m;
    const along = this.groundAt(x + d, y) - this.groundAt(x - d, y);
    return [along / (2 * d), (this.groundAt(x, y + d) - this.groundAt(x, y - d)) / (2 * d)];
  }

  /** The window in metres that holds the whole place: [left, bottom, right, top]. */
  wholeWindow() {
    const f = this.frame;
    return [f.x_m, f.y_m, f.x_m + f.columns * f.cell_m, f.y_m + f.rows * f.cell_m];
  }

  /** The window that holds all that was ever mapped, and all robots. */
  seenWindow() {
    let [left, bottom, right, top] = [Infinity, Infinity, -Infinity, -Infinity];
    const take = (x, y) => {
      left = Math.min(left, x);
      right = Math.max(right, x);
      bottom = Math.min(bottom, y);
      top = Math.max(top, y);
    };
    const { knownSince } = this.swarmMap;
    for (let cell = 0; cell < knownSince.length; cell++) {
      if (knownSince[cell] !== NEVER) take(...this.centre(cell));
    }
    const at = this.last * this.robots;
    for (let i = 0; i < this.robots && this.steps; i++) {
      take(this.columns.x_m[at + i] / 1000, this.columns.y_m[at + i] / 1000);
    }
    if (!(left <= right)) return this.wholeWindow();
    return [left - MARGIN_M, bottom - MARGIN_M, right + MARGIN_M, top + MARGIN_M];
  }
}

function readRelief(facts, arrays) {
  const ground = new Float32Array(facts.rows * facts.columns);
  let sum = 0;
  arrays["relief.ground"].forEach((difference, i) => {
    sum += difference;
    ground[i] = sum / 1000;
  });
  return { ...facts, ground, share: arrays["relief.share"] };
}
