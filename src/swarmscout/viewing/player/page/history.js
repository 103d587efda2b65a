// How a map grew: every change of a cell, so that the map can be had at any step, forward or backward.

export const UNKNOWN = 0;
export const FREE = 1;
export const OCCUPIED = 2;
export const NEVER = 0x7fffffff;

export class MapHistory {
  /** @param facts the mission's: frame, thresholds, neighbours of a frontier; @param robot whose map, -1: all robots'. */
  constructor(facts, robot = -1) {
    this.facts = facts;
    this.robot = robot;
    this.frame = facts.frame;
    const cells = facts.frame.rows * facts.frame.columns;
    this.steps = 0; // how many steps are here, step 0 included
    this.step = -1; // the map stands after this step
    this.logOdds = new Int16Array(cells);
    this.labels = new Uint8Array(cells);
    this.knownSince = new Int32Array(cells).fill(NEVER);
    this.changeEnds = [0]; // changes of step s: changeEnds[s] … changeEnds[s + 1]
    this.changes = { cell: new Int32Array(0), next: new Int16Array(0), before: new Int16Array(0) };
    this.latest = new Int16Array(cells); // the map after the last step that is here
  }

  /** Add the changes of some steps; those that do not follow on what is here are left alone. */
  append(facts, arrays) {
    if (facts.first !== this.steps) return;
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
    this.steps += facts.steps;
  }

  labelOf(odds) {
    if (odds < this.facts.free_below) return FREE;
    return odds > this.facts.occupied_above ? OCCUPIED : UNKNOWN;
  }

  /** Bring `logOdds` and `labels` to the state after a step. */
  seek(step) {
    const { cell, next, before } = this.changes;
    const from = this.changeEnds[this.step + 1];
    const to = this.changeEnds[step + 1];
    for (let i = from; i < to; i++) this.#put(cell[i], next[i]);
    for (let i = from - 1; i >= to; i--) this.#put(cell[i], before[i]);
    this.step = step;
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
}

/** A typed array with room for so many numbers: the same one, or one twice as long. */
export function roomFor(array, length) {
  if (length <= array.length) return array;
  const longer = new array.constructor(array.length ? Math.max(length, 2 * array.length) : length);
  longer.set(array);
  return longer;
}
