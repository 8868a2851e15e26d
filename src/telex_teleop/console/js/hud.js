// @ts-check
/** What stands over the picture besides the camera's own state: heading, gripper, what moves, and how good the link is. */

import { byId, fixed, setText } from "./panels.js";
import { GRIPPER_JOINT } from "./robot.js";

export const IMU = { topic: "imu", type: "sensor_msgs/Imu" };

/** Longest round trip (ms) and age of the picture (ms), least pictures per second with which the link is good, and fair. */
const GOOD = { trip: 100, age: 200, rate: 8 };
const FAIR = { trip: 300, age: 500, rate: 4 };

export class Hud {
  constructor() {
    /** Action that is held, or was last. */
    this._selected = "";
    /** Joint that it moves, empty if it is about something else. */
    this._joint = "";
    this._label = "";
  }

  /** @param {any} imu  sensor_msgs/Imu */
  setHeading({ orientation: { x, y, z, w } }) {
    const yaw = Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
    // As on a compass: clockwise from where the scene's x axis points.
    const heading = Math.round((-yaw * 180) / Math.PI + 720) % 360;
    setText(byId("heading"), `${String(heading).padStart(3, "0")}°`);
  }

  /**
   * @param {import("./joints.js").JointPositions} joints
   * @param {import("./gripper.js").Gripper} gripper
   */
  showGripper(joints, gripper) {
    const opening = gripper.opening(joints), force = gripper.force(joints);
    const angle = joints.position(GRIPPER_JOINT);
    // A gripper of another make tells no more than its angle.
    const open = opening !== null ? `${Math.round(1000 * opening)} mm` : angle === undefined ? "–" : `${fixed((angle * 180) / Math.PI, 0)}°`;
    const { trouble } = gripper;
    const grip = byId("grip");
    if (grip.dataset.trouble !== trouble) grip.dataset.trouble = trouble;
    setText(grip, [open, force === null ? "" : `${fixed(force, 0)} N`, trouble.toUpperCase()].filter(Boolean).join(" "));
  }

  /**
   * What moves, or moved last.
   * @param {{name: string, action: import("./robot.js").Action}[]} held
   * @param {(joint: string) => string} format
   */
  showSelected(held, format) {
    const last = held.at(-1);
    if (last !== undefined) this._selected = last.name;
    const action = last?.action;
    if (action !== undefined) this._joint = action.kind === "joints" ? action.joints[0] : "";
    const [what, way] = this._selected.split(":");
    const label = action?.label ?? this._label;
    this._label = label;
    const rest = this._joint ? format(this._joint) : label.startsWith(what) ? label.slice(what.length + 1) : label || way;
    setText(byId("selected"), this._selected === "" ? "–" : `${what.replace(/_/g, " ")} ${rest}`);
  }

  /**
   * @param {import("./bridge.js").Bridge} bridge
   * @param {import("./cameras.js").ViewState} video
   */
  showLink(bridge, video) {
    const trip = bridge.connected ? bridge.roundTrip ?? Infinity : Infinity;
    const age = video.live ? video.latency ?? 0 : Infinity;
    const is = (/** @type {typeof GOOD} */ least) => trip <= least.trip && age <= least.age && video.rate >= least.rate;
    const quality = !bridge.connected || bridge.silence > 1000 ? "lost" : is(GOOD) ? "good" : is(FAIR) ? "fair" : "poor";
    const view = byId("view");
    if (view.dataset.link !== quality) view.dataset.link = quality;
    setText(byId("link-quality"), `link ${quality}`);
  }
}
