// @ts-check
/** How far the gripper is open and how hard it grips, from the angles and torques of its fingers. */

import { getParameter } from "./parameters.js";
import { FINGER_BASES, GRIPPER_JOINT } from "./robot.js";

const PARAMETER = "gripper_controller/geometry";

export const CONTACT = { topic: "sim/gripper_contact", type: "telex_msgs/GripperContact" };

/** Share of the friction that there is from which on a grip is nearly too weak. */
const WEAK = 0.8;
const FELT_FOR = 1000; // ms that what the pads felt counts

/**
 * @typedef {object} Geometry  Of a finger, as the robot's gripper controller has it.
 * @property {number} base    Length of its first link (m).
 * @property {number} middle  Of the second one (m).
 * @property {number} lean    How far both lean inwards where the pads meet (rad).
 * @property {number} pad     From the tip's joint to the middle of the pad (m).
 */

export class Gripper {
  constructor() {
    /** Null: not known. @type {Geometry | null} */
    this._geometry = null;
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

  /**
   * Ask for the gripper's geometry; call it after every new connection.
   * @param {import("./bridge.js").Bridge} bridge
   * @param {(name: string) => string} topic
   */
  async ask(bridge, topic) {
    try {
      const found = await getParameter(bridge, topic(PARAMETER));
      const isWhole = ["base", "middle", "lean", "pad"].every((key) => Number.isFinite(found?.[key]));
      this._geometry = isWhole ? found : null;
    } catch {
      // What was known before still holds.
    }
  }

  /** Distance of the pads (m); null while it is not known. @param {import("./joints.js").JointPositions} joints */
  opening(joints) {
    const angle = joints.position(GRIPPER_JOINT);
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
    const angle = joints.position(GRIPPER_JOINT);
    const torques = /** @type {number[]} */ (FINGER_BASES.map((base) => joints.effort(base)).filter(Number.isFinite));
    if (this._geometry === null || angle === undefined || torques.length < FINGER_BASES.length) return null;
    const { base, middle, lean, pad } = this._geometry;
    const lever = base * Math.cos(lean - angle) + middle * Math.cos(lean - 2 * angle) + pad;
    return Math.max(0, Math.min(...torques.map((torque) => -torque))) / lever;
  }
}
