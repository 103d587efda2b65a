// What one robot does: its rays, and the route that it follows.

/** The rays of a robot: `{x, y, hit}` where each ends. Without the sensor's noise, which is not recorded. */
export function raysOf(mission, robot) {
  const { angles_deg: angles, range_m: range, nearest } = mission.facts.sensor;
  const step = mission.raster.cell_m / 4;
  const rays = angles.map((offset) => {
    const angle = robot.heading + (offset * Math.PI) / 180;
    const [dx, dy] = [Math.cos(angle), Math.sin(angle)];
    let r = 0;
    while (r < range && mission.isFree(robot.x + r * dx, robot.y + r * dy)) r += step;
    return { dx, dy, r: Math.min(r, range) };
  });
  // A cone measures the nearest obstacle in it.
  const least = nearest ? Math.min(...rays.map(({ r }) => r)) : Infinity;
  return rays.map(({ dx, dy, r }) => {
    const end = Math.min(r, least);
    return { x: robot.x + end * dx, y: robot.y + end * dy, hit: end < range };
  });
}

const STRAIGHT = [[0, 1], [1, 0], [0, -1], [-1, 0]];
const DIAGONAL = [[1, 1], [1, -1], [-1, -1], [-1, 1]];

/**
 * A cheapest route over the map at the step of `mission.seek`, as points in metres, or null.
 *
 * Costs are those of the mission's planner (a move costs its length times the mean price of its two
 * cells, corners are not cut); it may take another one of several equally good routes.
 */
export function routeOf(mission, robot) {
  const goals = goalsOf(mission, robot);
  const start = mission.cellAt(robot.x, robot.y);
  if (!goals.size || start < 0) return null;
  const { rows, columns } = mission.frame;
  const base = mission.facts.route_cost === "probability" ? 0 : 1;
  const price = (cell) => base + 1 / (1 + Math.exp(-mission.logOdds[cell] / 1000));
  const cost = new Map([[start, 0]]);
  const from = new Map();
  const heap = new Heap();
  heap.push(0, start);
  const blocked = (row, col) =>
    row < 0 || col < 0 || row >= rows || col >= columns || mission.labels[row * columns + col] === 2;
  while (heap.size) {
    const [far, cell] = heap.pop();
    if (far > cost.get(cell)) continue;
    if (goals.has(cell)) return pathTo(mission, from, cell);
    const row = Math.floor(cell / columns);
    const col = cell % columns;
    const visit = (dr, dc, length) => {
      const next = (row + dr) * columns + col + dc;
      const total = far + (length * (price(cell) + price(next))) / 2;
      if (total < (cost.get(next) ?? Infinity)) {
        cost.set(next, total);
        from.set(next, cell);
        heap.push(total, next);
      }
    };
    for (const [dr, dc] of STRAIGHT) if (!blocked(row + dr, col + dc)) visit(dr, dc, 1);
    for (const [dr, dc] of DIAGONAL) {
      if (!blocked(row + dr, col + dc) && !blocked(row + dr, col) && !blocked(row, col + dc)) {
        visit(dr, dc, Math.SQRT2);
      }
    }
  }
  return null;
}

/** The cells that a robot heads for: its destination, or the cells round the stations. */
function goalsOf(mission, robot) {
  if (!robot.alive) return new Set();
  if (!robot.charging) return new Set(robot.destination >= 0 ? [robot.destination] : []);
  const goals = new Set();
  const cell = mission.frame.cell_m;
  for (const [x, y] of mission.facts.stations_m) {
    if (Math.hypot(robot.x - x, robot.y - y) <= mission.facts.station_range_m) return new Set();
    for (let i = -1; i <= 1; i++) {
      for (let j = -1; j <= 1; j++) goals.add(mission.cellAt(x + i * cell, y + j * cell));
    }
  }
  return goals;
}

function pathTo(mission, from, cell) {
  const path = [];
  for (let at = cell; at !== undefined; at = from.get(at)) path.push(mission.centre(at));
  return path.reverse();
}

class Heap {
  #items = [];

  get size() {
    return this.#items.length;
  }

  push(key, value) {
    const items = this.#items;
    let child = items.push([key, value]) - 1;
    while (child > 0) {
      const parent = (child - 1) >> 1;
      if (items[parent][0] <= items[child][0]) break;
      [items[parent], items[child]] = [items[child], items[parent]];
      child = parent;
    }
  }

  pop() {
    const items = this.#items;
    const top = items[0];
    const moved = items.pop();
    if (items.length) {
      items[0] = moved;
      let parent = 0;
      for (;;) {
        let child = 2 * parent + 1;
        if (child >= items.length) break;
        if (child + 1 < items.length && items[child + 1][0] < items[child][0]) child++;
        if (items[parent][0] <= items[child][0]) break;
        [items[parent], items[child]] = [items[child], items[parent]];
        parent = child;
      }
    }
    return top;
  }
}
