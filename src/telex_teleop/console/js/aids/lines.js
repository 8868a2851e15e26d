// @ts-check
/** Lines about the robot, in its root link's frame (m): x ahead, y to the left, z up. */

/** @typedef {import("../urdf.js").Vector} Vector */
/** @typedef {import("../urdf.js").Pose} Pose */

/** @typedef {{z: number, alongX: number, alongY: number}} Floor  Height below the origin, and slopes. */
/** @typedef {{front: number, rear: number, half: number, bottom: number}} Gear  Ends, half the width and underside of tracks or wheels. */
/** @typedef {{distance: number, rung: Vector[], sides: Vector[][]}} Guide  Across, and both sides from the last one to it. */

/** Distances of the guide lines from the end of the tracks (m). */
export const DISTANCES = [0.5, 1, 2];

const LEAST_SPREAD = 0.02; // m, standard deviation: on points that are nearer to each other nothing lies flat
const STEEPEST = 0.7; // slope to the robot beyond which it leans against something rather than stand on it
const SAME_HEIGHT = 0.003, SAME_SLOPE = 0.005; // m, and slope: belts that run shake by as much
const HORIZON_REACH = 75, HORIZON_STEP = 5; // degrees to either side of where the camera looks
const LEAST_VIEW = 0.2; // length of the camera's axis, seen from above, below which it looks straight up or down

/** @param {Vector} a @param {Vector} b @param {number} [factor] @returns {Vector}  a + factor b */
export const plus = (a, b, factor = 1) => [a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]];

/** @param {Vector} a @param {Vector} b */
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** @param {Vector} a @returns {Vector | null}  Of length 1; null: it has none. */
export function unit(a) {
  const length = Math.hypot(...a);
  return length > 1e-6 ? [a[0] / length, a[1] / length, a[2] / length] : null;
}

/** @param {number[]} r  3x3, row by row. @param {0 | 1 | 2} index @returns {Vector} */
export const column = (r, index) => [r[index], r[index + 3], r[index + 6]];

/**
 * The plane through points, by least squares; null: they do not span one on which the robot could stand.
 * @param {Vector[]} points
 * @returns {Floor | null}
 */
export function floorThrough(points) {
  const count = points.length;
  if (count < 3 || !points.flat().every(Number.isFinite)) return null;
  const mean = points.reduce((sum, each) => plus(sum, each, 1 / count), /** @type {Vector} */ ([0, 0, 0]));
  let [xx, xy, yy, xz, yz] = [0, 0, 0, 0, 0];
  for (const point of points) {
    const [x, y, z] = plus(point, mean, -1);
    xx += (x * x) / count;
    xy += (x * y) / count;
    yy += (y * y) / count;
    xz += (x * z) / count;
    yz += (y * z) / count;
  }
  const determinant = xx * yy - xy * xy;
  // The smaller variance of both main axes.
  const least = (xx + yy) / 2 - Math.sqrt(Math.max(0, ((xx + yy) / 2) ** 2 - determinant));
  if (!(least > LEAST_SPREAD ** 2)) return null;
  const alongX = (xz * yy - yz * xy) / determinant, alongY = (yz * xx - xz * xy) / determinant;
  if (Math.hypot(alongX, alongY) > STEEPEST) return null;
  return { z: mean[2] - alongX * mean[0] - alongY * mean[1], alongX, alongY };
}

/** Whether guide lines on two floors can be told apart. @param {Floor} a @param {Floor} b */
export const differ = (a, b) => Math.abs(a.z - b.z) > SAME_HEIGHT || Math.hypot(a.alongX - b.alongX, a.alongY - b.alongY) > SAME_SLOPE;

/**
 * Where tracks or wheels are, by the places of their axles.
 * @param {Vector[]} axles
 * @param {number} radius
 * @param {number} half  Half the width over both sides.
 * @returns {Gear | null}
 */
export function gearOf(axles, radius, half) {
  if (axles.length === 0 || !(radius > 0) || !(half > 0)) return null;
  const xs = axles.map(([x]) => x), zs = axles.map(([, , z]) => z);
  return { front: Math.max(...xs) + radius, rear: Math.min(...xs) - radius, half, bottom: Math.min(...zs) - radius };
}

/**
 * Guide lines on the floor ahead of the tracks, or behind them.
 * @param {Gear} gear
 * @param {Floor} floor
 * @param {1 | -1} way  Ahead or behind.
 * @returns {Guide[]}
 */
export function guideLines({ front, rear, half }, floor, way) {
  const begin = way > 0 ? front : rear;
  // Distances count along the floor.
  const share = way / Math.hypot(1, floor.alongX);
  const at = (/** @type {number} */ distance, /** @type {number} */ y) => onFloor(floor, begin + share * distance, y);
  return DISTANCES.map((distance, index) => {
    const before = index === 0 ? 0 : DISTANCES[index - 1];
    return { distance, rung: [at(distance, half), at(distance, -half)], sides: [half, -half].map((y) => [at(before, y), at(distance, y)]) };
  });
}

/** @param {Floor} floor @param {number} x @param {number} y @returns {Vector} */
const onFloor = ({ z, alongX, alongY }, x, y) => [x, y, z + alongX * x + alongY * y];

/**
 * Which way is up.
 * @param {number} roll   rad
 * @param {number} pitch  rad, positive with the nose down
 * @returns {Vector}
 */
export function upward(roll, pitch) {
  return [-Math.sin(pitch), Math.cos(pitch) * Math.sin(roll), Math.cos(pitch) * Math.cos(roll)];
}

/**
 * Where a camera's axis points, level; null: straight up or down.
 * @param {Pose} camera  Of its optical frame.
 * @param {Vector} up
 * @returns {Vector | null}
 */
export function levelAhead({ rotation }, up) {
  const axis = column(rotation, 2);
  const level = plus(axis, up, -dot(axis, up));
  return Math.hypot(...level) > LEAST_VIEW ? unit(level) : null;
}

/**
 * Directions towards the horizon, from the camera's left to its right.
 * @param {Pose} camera  Of its optical frame.
 * @param {Vector} up
 * @returns {Vector[]}
 */
export function horizon(camera, up) {
  const ahead = levelAhead(camera, up);
  if (ahead === null) return [];
  const left = cross(up, ahead);
  const directions = [];
  for (let degrees = HORIZON_REACH; degrees >= -HORIZON_REACH; degrees -= HORIZON_STEP) {
    const angle = (degrees * Math.PI) / 180;
    directions.push(plus(plus([0, 0, 0], ahead, Math.cos(angle)), left, Math.sin(angle)));
  }
  return directions;
}

/** @param {Vector} a @param {Vector} b @returns {Vector} */
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
