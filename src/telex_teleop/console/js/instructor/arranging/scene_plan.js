// @ts-check
/** What is in the scene and where it is now, as a plan shows it; of sim/list_objects and sim/poses. */

/** @typedef {[number, number]} Point  m */
/** @typedef {{x: number, y: number, z: number, heading: number}} Place  m, rad */
/**
 * @typedef {object} Thing
 * @property {string} name
 * @property {boolean} movable
 * @property {number} bottom       m; of what can move, in its own frame
 * @property {number} top
 * @property {Point[][]} outlines  In the world; of what can move, in its own frame.
 * @property {number} frame        Its place among the poses; -1: it stands fast.
 */

const NUMBERS = 7; // of a frame's pose

export class ScenePlan {
  /** @param {any} listed  telex_msgs/ListObjectsResponse */
  constructor(listed) {
    this.revision = /** @type {number} */ (listed.revision);
    this.floor = /** @type {number} */ (listed.floor);
    /** @type {{name: string, frame: number}[]} */
    this.robots = listed.robots.map((/** @type {string} */ name, /** @type {number} */ index) =>
      ({ name, frame: listed.frames.indexOf(listed.bases[index]) }));
    /** @type {Thing[]} */
    this.things = listed.objects.map((/** @type {any} */ thing) => ({
      name: thing.name, movable: thing.movable, bottom: thing.bottom, top: thing.top,
      outlines: outlinesOf(thing), frame: thing.frame === "world" ? -1 : listed.frames.indexOf(thing.frame),
    }));
    /** @type {number[]} */
    this._poses = [];
  }

  /** @param {{revision: number, poses: number[]}} message  telex_msgs/ScenePoses @returns {boolean} Whether it is of these things. */
  hear({ revision, poses }) {
    if (revision !== this.revision) return false;
    this._poses = poses;
    return true;
  }

  /** Where a frame is; null: not known. @param {number} frame @returns {Place | null} */
  place(frame) {
    const [x, y, z, a, b, c, d] = this._poses.slice(NUMBERS * frame, NUMBERS * (frame + 1));
    if (frame < 0 || !Number.isFinite(d)) return null;
    return { x, y, z, heading: Math.atan2(2 * (d * c + a * b), 1 - 2 * (b * b + c * c)) };
  }

  /** Outlines of a thing as it stands now. @param {Thing} thing @returns {Point[][]} */
  outlines(thing) {
    if (thing.frame < 0) return thing.outlines;
    const place = this.place(thing.frame);
    return place === null ? [] : thing.outlines.map((outline) => outline.map((point) => placed(point, place)));
  }

  /** Least and greatest x and y of all that stands fast and of the robots (m). */
  get extent() {
    const points = [
      ...this.things.filter(({ frame }) => frame < 0).flatMap(({ outlines }) => outlines.flat()),
      ...this.robots.map(({ frame }) => this.place(frame)).filter((place) => place !== null).map(({ x, y }) => [x, y]),
    ];
    const xs = points.map(([x]) => x), ys = points.map(([, y]) => y);
    const least = (/** @type {number[]} */ all) => all.reduce((a, b) => Math.min(a, b), -2);
    const most = (/** @type {number[]} */ all) => all.reduce((a, b) => Math.max(a, b), 2);
    return { left: least(xs), right: most(xs), low: least(ys), high: most(ys) };
  }
}

/** @param {{corners: number[], outlines: number[]}} thing  telex_msgs/SceneThing @returns {Point[][]} */
function outlinesOf({ corners, outlines }) {
  let at = 0;
  return corners.map((count) => Array.from({ length: count }, () => /** @type {Point} */ ([outlines[at++], outlines[at++]])));
}

/** @param {Point} point  @param {Place} place @returns {Point} */
function placed([x, y], { x: left, y: down, heading }) {
  const c = Math.cos(heading), s = Math.sin(heading);
  return [left + c * x - s * y, down + s * x + c * y];
}
