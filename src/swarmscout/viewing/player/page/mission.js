// A mission's data: every robot at every step, the map at any step, decisions, events, curves.

export const UNKNOWN = 0;
export const FREE = 1;
export const OCCUPIED = 2;

const MARGIN_M = 2.5; // shown round what was mapped

const COLUMNS = {
  x: Int32Array, y: Int32Array, heading: Int16Array, charge: Int16Array, state: Uint8Array,
  leader: Int32Array, desired: Int32Array, destination: Int32Array, team: Int32Array,
};

export class Mission {
  /** @param packet the mission packet: facts, relief, free raster. */
  constructor({ facts, arrays }) {
    this.facts = facts;
    this.robots = facts.robots;
    this.frame = facts.frame;
    this.steps = 0; // how many steps are here, step 0 included
    this.columns = {};
    for (const [name, Type] of Object.entries(COLUMNS)) this.columns[name] = new Type(0);
    this.teams = []; // team ids, in the order of their numbers in columns.team
    this.teamNumbers = new Map();
    this.decisions = [];
    this.events = { step: [], kind: [], robot: [], other: [], value: [] };
    this.coverage = {};
    this.relief = readRelief(facts.relief, arrays);
    this.raster = { ...facts.raster, free: arrays.free };

    const cells = this.frame.rows * this.frame.columns;
    this.mapStep = -1; // the map stands after this step
    this.logOdds = new Int16Array(cells);
    this.labels = new Uint8Array(cells);
    this.knownSince = new Int32Array(cells).fill(0x7fffffff);
    this.changeEnds = [0]; // changes of step s: changeEnds[s] … changeEnds[s + 1]
    this.changes = { cell: new Int32Array(0), next: new Int16Array(0), before: new Int16Array(0) };
    this.latest = new Int16Array(cells); // the map after the last step that is here
  }

  get last() {
    return Math.max(0, this.steps - 1);
  }

  /** Add a block; one that does not follow on what is here is left alone. Returns whether it was added. */
  append({ facts, arrays }) {
    if (facts.first !== this.steps || !facts.steps) return false;
    const n = this.robots;
    const begin = facts.first * n;
    const end = begin + facts.steps * n;
    for (const name of Object.keys(COLUMNS)) {
      const column = (this.columns[name] = roomFor(this.columns[name], end));
      const first = arrays[`${name}.first`];
      const rest = arrays[`${name}.rest`];
      column.set(first, begin);
      for (let i = 0, at = begin + n; at < end; i++, at++) column[at] = column[at - n] + rest[i];
    }
    this.#renumberTeams(facts.teams, begin, end);
    this.#appendMap(facts, arrays);
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

  #appendMap(facts, arrays) {
    const cells = arrays["map.cells"];
    const odds = arrays["map.log_odds"];
    let at = this.changeEnds.at(-1);
    for (const name of ["cell", "next", "before"]) {
      this.changes[name] = roomFor(this.changes[name], at + cells.length);
    }
    const { cell, next, before } = this.changes;
    let i = 0;
    let where = 0;
    for (let s = 0; s < facts.steps; s++) {
      for (let k = arrays["map.counts"][s]; k > 0; k--, i++, at++) {
        where += cells[i];
        cell[at] = where;
        next[at] = odds[i];
        before[at] = this.latest[where];
        this.latest[where] = odds[i];
        if (this.labelOf(odds[i]) !== UNKNOWN && this.knownSince[where] > facts.first + s) {
          this.knownSince[where] = facts.first + s;
        }
      }
      this.changeEnds.push(at);
    }
  }

  labelOf(odds) {
    if (odds < this.facts.free_below) return FREE;
    return odds > this.facts.occupied_above ? OCCUPIED : UNKNOWN;
  }

  /** Bring `logOdds` and `labels` to the state after a step, forward or backward. */
  seek(step) {
    const { cell, next, before } = this.changes;
    const from = this.changeEnds[this.mapStep + 1];
    const to = this.changeEnds[step + 1];
    for (let i = from; i < to; i++) this.#put(cell[i], next[i]);
    for (let i = from - 1; i >= to; i--) this.#put(cell[i], before[i]);
    this.mapStep = step;
  }

  #put(cell, odds) {
    this.logOdds[cell] = odds;
    this.labels[cell] = this.labelOf(odds);
  }

  /** uint8 per cell: 1 for a free cell with an unknown one beside it, at the step of `seek`. */
  frontiers(into) {
    const { rows, columns } = this.frame;
    const labels = this.labels;
    const beside = [1, -1, columns, -columns];
    const across = this.facts.frontier_neighbours === 4
      ? []
      : [[1, columns], [-1, columns], [1, -columns], [-1, -columns]];
    // What lies behind a corner of two occupied cells does not count.
    const isOpen = (cell) => beside.some((d) => labels[cell + d] === UNKNOWN)
      || across.some(([a, b]) => labels[cell + a + b] === UNKNOWN
        && (labels[cell + a] !== OCCUPIED || labels[cell + b] !== OCCUPIED));
    into.fill(0);
    for (let row = 0; row < rows; row++) {
      for (let col = 0; col < columns; col++) {
        const cell = row * columns + col;
        if (labels[cell] !== FREE) continue;
        const inner = row > 0 && row < rows - 1 && col > 0 && col < columns - 1;
        if (!inner || isOpen(cell)) into[cell] = 1;
      }
    }
    return into;
  }

  /** A robot at a moment, between two steps too. Positions in metres, heading in radians. */
  robotAt(robot, time) {
    const step = Math.min(Math.floor(time), this.last);
    const share = step < this.last ? time - step : 0;
    const a = step * this.robots + robot;
    const b = share > 0 ? a + this.robots : a;
    const c = this.columns;
    let turn = c.heading[b] - c.heading[a];
    turn -= 3600 * Math.round(turn / 3600);
    const state = c.state[a];
    return {
      robot,
      x: (c.x[a] + (c.x[b] - c.x[a]) * share) / 1000,
      y: (c.y[a] + (c.y[b] - c.y[a]) * share) / 1000,
      heading: ((c.heading[a] + turn * share) * Math.PI) / 1800,
      charge: c.charge[a] / 1000,
      charging: (state & 1) === 1,
      action: (state >> 1) & 3,
      contact: (state >> 3) & 3,
      alive: ((state >> 5) & 1) === 1,
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
    for (let cell = 0; cell < this.knownSince.length; cell++) {
      if (this.knownSince[cell] !== 0x7fffffff) take(...this.centre(cell));
    }
    const at = this.last * this.robots;
    for (let i = 0; i < this.robots && this.steps; i++) {
      take(this.columns.x[at + i] / 1000, this.columns.y[at + i] / 1000);
    }
    if (!(left <= right)) return this.wholeWindow();
    return [left - MARGIN_M, bottom - MARGIN_M, right + MARGIN_M, top + MARGIN_M];
  }
}

/** A typed array with room for so many numbers: the same one, or one twice as long. */
function roomFor(array, length) {
  if (length <= array.length) return array;
  const longer = new array.constructor(array.length ? Math.max(length, 2 * array.length) : length);
  longer.set(array);
  return longer;
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
