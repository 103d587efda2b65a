// Which moment is shown: playing, stepping, scrubbing.

export const SPEEDS = [1, 2, 5, 10, 20, 50, 100, 200]; // steps per second

export class Clock {
  /** @param changed called whenever the moment or the state of playing changes. */
  constructor(changed) {
    this.changed = changed;
    this.time = 0; // in steps; between two of them while playing
    this.last = 0;
    this.playing = false;
    this.speed = 10;
    this.atEnd = false; // stay with a running mission's newest step
  }

  get step() {
    return Math.floor(this.time + 1e-9);
  }

  /** There are steps up to this one now. */
  extend(last) {
    this.last = last;
    if (this.atEnd) this.time = last;
    this.changed();
  }

  goTo(step) {
    this.time = Math.max(0, Math.min(this.last, Math.round(step)));
    this.atEnd = false;
    this.changed();
  }

  play(on = !this.playing) {
    if (on && this.time >= this.last) this.time = 0;
    this.playing = on;
    this.atEnd = false;
    if (!on) this.time = this.step;
    this.before = null;
    this.changed();
  }

  faster(by) {
    const at = SPEEDS.indexOf(this.speed) + by;
    this.speed = SPEEDS[Math.max(0, Math.min(SPEEDS.length - 1, at))];
    this.changed();
  }

  /** Let time pass, up to a moment of `performance.now()`. */
  tick(now) {
    if (!this.playing) return;
    const passed = this.before == null ? 0 : Math.min(0.25, (now - this.before) / 1000);
    this.before = now;
    this.time = Math.min(this.last, this.time + passed * this.speed);
    if (this.time >= this.last) this.play(false);
  }
}
