// @ts-check
/** A camera as its sensor_msgs/CameraInfo describes it: where in the picture it shows a point. */

/** @typedef {import("../urdf.js").Vector} Vector */

/**
 * @typedef {object} Lens  Of a pinhole camera with distortion "plumb_bob", in pixels whose centres have whole numbers.
 * @property {number} width
 * @property {number} height
 * @property {number} fx
 * @property {number} fy
 * @property {number} skew
 * @property {number} cx
 * @property {number} cy
 * @property {number[]} distortion  k1, k2, p1, p2, k3
 * @property {number} limit         Square of the slope from the axis from which on the model folds the picture back.
 */

/** Slope from the axis, squared, beyond which nothing is drawn (about 80 degrees), and steps in which a fold is looked for. */
const WIDEST = 32, STEPS = 400;

const HALVINGS = 40; // of the interval in which the edge's ray is looked for

/** @param {number} square  Of the slope. @param {number[]} distortion */
const radial = (square, [k1, k2, , , k3]) => 1 + square * (k1 + square * (k2 + square * k3));

/** @param {number[]} distortion */
function limitOf([k1, k2, , , k3]) {
  for (let step = 1; step <= STEPS; step += 1) {
    const square = (WIDEST * step) / STEPS;
    if (1 + square * (3 * k1 + square * (5 * k2 + square * 7 * k3)) <= 0) return (WIDEST * (step - 1)) / STEPS;
  }
  return WIDEST;
}

/**
 * @param {{width: number, height: number, distortion_model: string, D: number[], K: number[]}} info  sensor_msgs/CameraInfo
 * @returns {Lens}  Throws an Error that says why nothing can be drawn by it.
 */
export function lensOf({ width, height, distortion_model: model, D, K }) {
  if (![width, height, ...K, ...D].every(Number.isFinite)) throw new Error("its camera_info has numbers that are none");
  const [fx, skew, cx, , fy, cy] = K;
  if (!(width > 0 && height > 0 && fx > 0 && fy > 0)) throw new Error("its camera_info has no size or no focal length: it is not calibrated");
  const bends = D.some((each) => each !== 0);
  if (bends && (model !== "plumb_bob" || D.length > 5)) {
    throw new Error(`its lens has the distortion model "${model}" with ${D.length} numbers; only plumb_bob, with up to 5, can be drawn by`);
  }
  const distortion = [0, 1, 2, 3, 4].map((index) => D[index] ?? 0);
  return { width, height, fx, fy, skew, cx, cy, distortion, limit: limitOf(distortion) };
}

/**
 * The same camera zoomed in by a factor.
 * @param {Lens} lens
 * @param {number} factor
 * @returns {Lens}
 */
export function zoomed(lens, factor) {
  return { ...lens, fx: lens.fx * factor, fy: lens.fy * factor, skew: lens.skew * factor };
}

/**
 * Pixel that shows a point; null: it is behind the camera, or too far beside it.
 * @param {Lens} lens
 * @param {Vector} point  In the optical frame: z forward, x right, y down.
 * @returns {[number, number] | null}
 */
export function project({ fx, fy, skew, cx, cy, distortion, limit }, [px, py, pz]) {
  if (!(pz > 0)) return null;
  const x = px / pz, y = py / pz;
  const square = x * x + y * y;
  if (square >= limit) return null;
  const [, , p1, p2] = distortion;
  const bent = radial(square, distortion);
  const u = x * bent + 2 * p1 * x * y + p2 * (square + 2 * x * x);
  const v = y * bent + p1 * (square + 2 * y * y) + 2 * p2 * x * y;
  return [fx * u + skew * v + cx, fy * v + cy];
}

/** Full angle of view across the middle row (rad). @param {Lens} lens */
export function fieldOf({ width, fx, distortion, limit }) {
  const edge = width / 2 / fx;
  let [low, high] = [0, Math.sqrt(limit)];
  for (let each = 0; each < HALVINGS; each += 1) {
    const middle = (low + high) / 2;
    if (middle * radial(middle * middle, distortion) < edge) low = middle;
    else high = middle;
  }
  return 2 * Math.atan(low);
}
