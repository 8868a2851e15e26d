// @ts-check
/** Counts the pictures that are painted and how old they get, camera by camera, for `benchmarks/console`. Runs in the video worker. */

/**
 * @typedef {object} Steps  What became of a picture, and when (ms, performance.now()).
 * @property {number | null} captured  When its scene was; null: not known.
 * @property {number} received
 * @property {number} decoded
 * @property {number} painted
 *
 * @typedef {object} CameraTally
 * @property {number[]} seconds  Pictures painted in each second since the tally began.
 * @property {number} oldest     Age (ms) of the oldest picture that was still shown.
 * @property {number | null} captured  Of the picture that is shown.
 * @property {Steps[]} last      The newest pictures.
 */

const KEPT = 4000; // pictures

export class Tally {
  constructor() {
    this._begun = performance.now();
    /** @type {Map<string, CameraTally>} */
    this._cameras = new Map();
  }

  /**
   * @param {string} camera
   * @param {Steps} steps
   */
  add(camera, steps) {
    let tally = this._cameras.get(camera);
    if (tally === undefined) this._cameras.set(camera, tally = { seconds: [], oldest: 0, captured: null, last: [] });
    const second = Math.floor((steps.painted - this._begun) / 1000);
    while (tally.seconds.length <= second) tally.seconds.push(0);
    tally.seconds[second] += 1;
    this._age(tally, steps.painted);
    tally.captured = steps.captured;
    tally.last.push(steps);
    if (tally.last.length > KEPT) tally.last.shift();
  }

  /**
   * @param {CameraTally} tally
   * @param {number} now
   */
  _age(tally, now) {
    if (tally.captured !== null) tally.oldest = Math.max(tally.oldest, now - tally.captured);
  }

  /** Tell what was counted, and begin anew; `origin` is when performance.now() was 0 (ms since 1970). */
  take() {
    const now = performance.now();
    const length = (now - this._begun) / 1000;
    for (const tally of this._cameras.values()) this._age(tally, now);
    const cameras = Object.fromEntries(this._cameras);
    this._begun = now;
    // What is shown now goes on to grow old.
    this._cameras = new Map([...this._cameras].map(([name, { captured }]) => [name, { seconds: [], oldest: 0, captured, last: [] }]));
    return { length, origin: performance.timeOrigin, cameras };
  }
}
