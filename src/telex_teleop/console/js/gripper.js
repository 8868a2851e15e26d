// @ts-check
/** How far the gripper is open and how hard it grips, from the angles and torques of its fingers. */

export const CONTACT = { topic: "sim/gripper_contact", type: "telex_msgs/GripperContact" };

/** Share of the friction that there is from which on a grip is nearly too weak. */
const WEAK = 0.8;
const FELT_FOR = 1000; // ms for which a report of the pads counts

/**
 * @typedef {object} Geometry  Of a finger, as the robot's gripper controller has it.
 * @property {number} base    Length of its first link (m).
 * @property {number} middle  Of the second one (m).
 * @property {number} lean    How far both lean inwards where the pads meet (rad).
 * @property {number} pad     From the tip's joint to the middle of the pad (m).
 */

export class Gripper {
  /** @param {import("./robot.js").GripperFacts | null} facts */
  constructor(facts) {
    this._name = facts?.name ?? "";
    this._bases = facts?.measured_by ?? [];
    const geometry = facts?.geometry;
    const isWhole = [geometry?.base, geometry?.middle, geometry?.lean, geometry?.pad].every(Number.isFinite);
    /** Null: it is of another make. @type {Geometry | null} */
    this._geometry = isWhole ? geometry ?? null : null;
    this._felt = { at: -Infinity, slipping: false, weak: false };
  }

  /** @param {any} message  telex_msgs/GripperContact */
  feel({ object, slipping, pads }) {
    const weak = object !== "" && pads.some((/** @type {{friction_use: number | null}} */ pad) => (pad.friction_use ?? 0) > WEAK);
    this._felt = { at: performance.now(), slipping, weak };
  }

  /** What is wrong with the grip: "slipping", "weak", or nothing. */
  get trouble() {
    const { at, slipping, weak } = this._felt;
    if (performance.now() - at > FELT_FOR) return "";
    return slipping ? "slipping" : weak ? "weak" : "";
  }

  /** By which all its joints are moved together; empty: there is none. */
  get name() {
    return this._name;
  }

  /** Distance of the pads (m); null while it is not known. @param {import("./joints.js").JointPositions} joints */
  opening(joints) {
    const angle = joints.position(this._name);
    if (this._geometry === null || angle === undefined) return null;
    const { base, middle, lean } = this._geometry;
    const { sin } = Math;
    // Both links turn outwards by the angle; the second one turns against the first as well.
    const half = base * (sin(lean) - sin(lean - angle)) + middle * (sin(lean) - sin(lean - 2 * angle));
    return Math.max(0, 2 * half);
  }

  /**
   * Force that clamps (N) by the torques with which the fingers' bases close, of the finger that closes less; null while it is not known.
   * Of an empty hand, shocks and its weight push one finger open and the other one closed, but in a hand that points up.
   * @param {import("./joints.js").JointPositions} joints
   */
  force(joints) {
    const angle = joints.position(this._name);
    const torques = /** @type {number[]} */ (this._bases.map((base) => joints.effort(base)).filter(Number.isFinite));
    if (this._geometry === null || angle === undefined || torques.length < this._bases.length) return null;
    const { base, middle, lean, pad } = this._geometry;
    const lever = base * Math.cos(lean - angle) + middle * Math.cos(lean - 2 * angle) + pad;
    return Math.max(0, Math.min(...torques.map((torque) => -torque))) / lever;
  }
}
