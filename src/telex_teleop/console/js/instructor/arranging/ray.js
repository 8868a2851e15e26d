// @ts-check
/** From a pixel of a camera's picture to the ray that it sees along, by the camera's calibration. */

/** @typedef {{x: number, y: number, z: number}} Vector */
/** @typedef {{origin: Vector, direction: Vector}} Ray  In the world (m). */
/** @typedef {{width: number, height: number, D: number[], K: number[]}} CameraInfo  sensor_msgs/CameraInfo, what is used of it. */
/** @typedef {{position: Vector, orientation: Vector & {w: number}}} Pose  Of the optical frame: z ahead, x to the right, y down. */

const ROUNDS = 20; // of undoing the distortion, which converges within a few

/**
 * The ray through a point of the picture.
 * @param {CameraInfo} info
 * @param {Pose} pose
 * @param {number} u  Share of the width from the left.
 * @param {number} v  Share of the height from above.
 * @returns {Ray}
 */
export function rayThrough({ width, height, D, K }, { position, orientation }, u, v) {
  const [x, y] = undistorted(D, (u * width - K[2]) / K[0], (v * height - K[5]) / K[4]);
  return { origin: position, direction: turned(orientation, { x, y, z: 1 }) };
}

/** A ray straight down. @param {number} x  @param {number} y  @param {number} z  From which height (m). @returns {Ray} */
export const rayDown = (x, y, z) => ({ origin: { x, y, z }, direction: { x: 0, y: 0, z: -1 } });

/**
 * Undo the distortion of a lens ("plumb_bob").
 * @param {number[]} distortion  k1, k2, p1, p2, k3; may be shorter.
 * @param {number} x  @param {number} y  In the picture, in multiples of the focal length.
 * @returns {[number, number]}
 */
function undistorted(distortion, x, y) {
  const [k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0] = distortion;
  let [a, b] = [x, y];
  for (let round = 0; round < ROUNDS; round += 1) {
    const r = a * a + b * b;
    const radial = 1 + r * (k1 + r * (k2 + r * k3));
    const right = 2 * p1 * a * b + p2 * (r + 2 * a * a);
    const down = p1 * (r + 2 * b * b) + 2 * p2 * a * b;
    [a, b] = [(x - right) / radial, (y - down) / radial];
  }
  return [a, b];
}

/** @param {Vector & {w: number}} q  @param {Vector} v @returns {Vector} */
function turned({ x, y, z, w }, v) {
  const cx = y * v.z - z * v.y, cy = z * v.x - x * v.z, cz = x * v.y - y * v.x;
  return {
    x: v.x + 2 * (w * cx + y * cz - z * cy),
    y: v.y + 2 * (w * cy + z * cx - x * cz),
    z: v.z + 2 * (w * cz + x * cy - y * cx),
  };
}

/**
 * Point of a picture under a position on the page; the picture is shown whole, centred, from the top; null: outside of it.
 * @param {DOMRect} box         Of the element that shows it.
 * @param {number} aspect       Width over height of the picture.
 * @param {{clientX: number, clientY: number}} at
 * @returns {[number, number] | null}  Shares of its width and height.
 */
export function pointIn(box, aspect, { clientX, clientY }) {
  const width = Math.min(box.width, box.height * aspect);
  const left = box.left + (box.width - width) / 2;
  const u = (clientX - left) / width, v = (clientY - box.top) / (width / aspect);
  return u >= 0 && u <= 1 && v >= 0 && v <= 1 ? [u, v] : null;
}
