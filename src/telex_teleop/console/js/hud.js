// @ts-check
/** Values over the picture: speed, heading, gripper, and the quality of link and picture. */

import { text, translated } from "./language.js";
import { byId, fixed, setText, showTwist } from "./panels.js";

/** Belts or wheels and gyroscope, whose bias it learns; `period`: as often as a good camera sends pictures. */
export const ODOMETRY = { type: "nav_msgs/Odometry", period: 40 };

const ODOMETRY_SILENT_AFTER = 1000; // ms

/** Longest round trip (ms) with which the link is good, and fair. */
const LINK = { good: 100, fair: 300 };

/** Longest age (ms) and least pictures per second with which the picture is good, and fair. */
const PICTURE = { good: { age: 200, rate: 8 }, fair: { age: 500, rate: 4 } };

/**
 * Where the robot points, as on a compass: clockwise.
 * @param {{x: number, y: number, z: number, w: number}} orientation
 */
export function headingOf(orientation) {
  if (![orientation.x, orientation.y, orientation.z, orientation.w].every(Number.isFinite)) return "–";
  return headingOfYaw(yawOf(orientation));
}

/** Where it points (rad, counter-clockwise). @param {{x: number, y: number, z: number, w: number}} orientation */
export const yawOf = ({ x, y, z, w }) => Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));

/** @param {number} yaw  rad, counter-clockwise */
export function headingOfYaw(yaw) {
  const heading = Math.round((-yaw * 180) / Math.PI + 720) % 360;
  return `${String(heading).padStart(3, "0")}°`;
}

export class Hud {
  constructor() {
    /** geometry_msgs/Twist, as measured. @type {any} */
    this._twist = null;
    this._heard = -Infinity;
    /** How good the link is, and the picture. */
    this.link = "unknown";
    this.picture = "unknown";
  }

  /** @param {any} odometry  nav_msgs/Odometry */
  setOdometry({ pose, twist }) {
    this._twist = twist.twist;
    this._heard = performance.now();
    setText(byId("heading"), headingOf(pose.pose.orientation));
  }

  /** Show how fast it drives by its belts. @param {boolean} stuck */
  showSpeed(stuck) {
    const isKnown = performance.now() - this._heard < ODOMETRY_SILENT_AFTER;
    if (!isKnown) setText(byId("heading"), "–");
    const speed = byId("speed-hud");
    const driven = isKnown ? showTwist(this._twist).join("  ") : "–";
    // Belts that slip run all the same.
    setText(speed, stuck ? text("STUCK, belts {speed}", { speed: driven }) : driven);
    if (speed.dataset.stuck !== String(stuck)) speed.dataset.stuck = String(stuck);
  }

  /**
   * @param {import("./joints.js").JointPositions} joints
   * @param {import("./gripper.js").Gripper} gripper
   * @param {(joint: string) => string} format  A joint's position.
   */
  showGripper(joints, gripper, format) {
    const opening = gripper.opening(joints), force = gripper.force(joints);
    // A gripper of another make tells no more than where its joints are.
    const open = opening !== null ? text("{gap} mm open", { gap: Math.round(1000 * opening) }) : format(gripper.name);
    const { trouble } = gripper;
    const grip = byId("grip");
    if (grip.dataset.trouble !== trouble) grip.dataset.trouble = trouble;
    setText(grip, [open, force === null ? "" : text("force {force} N", { force: fixed(force, 0) }), translated(trouble).toUpperCase()].filter(Boolean).join(", "));
  }

  /**
   * Show how good the link is, and apart from it how good the picture: a slow renderer is no fault of the network.
   * @param {import("./bridge.js").Bridge} bridge
   * @param {import("./line.js").Line} line
   * @param {import("./cameras.js").ViewState} video
   */
  showLink(bridge, line, video) {
    const trip = bridge.usualTrip;
    const isLost = !bridge.connected || bridge.silence > 1000;
    const known = trip === null ? "unknown" : trip <= LINK.good ? "good" : trip <= LINK.fair ? "fair" : "poor";
    // A radio signal tells more of what comes next than the messages that have come.
    const link = isLost ? "lost" : line.quality ?? known;
    const view = byId("view");
    const { signal } = line;
    const hue = signal === null ? "" : String(Math.round(120 * signal));
    if (view.style.getPropertyValue("--signal") !== hue) view.style.setProperty("--signal", hue);
    if (view.dataset.signal !== String(signal !== null)) view.dataset.signal = String(signal !== null);
    if (view.dataset.link !== link) view.dataset.link = link;
    const quality = text("link {quality}", { quality: link === "unknown" ? "–" : translated(link) });
    const words = byId("link-quality");
    setText(words, line.text === "" ? quality : `${quality}, ${line.text}`);
    // Where there is little room, all but good news is said.
    words.dataset.plain = String(line.text === "" && (link === "good" || link === "unknown"));
    const is = (/** @type {typeof PICTURE.good} */ { age, rate }) => (video.latency ?? 0) <= age && video.rate >= rate;
    const picture = !video.live ? "lost" : is(PICTURE.good) ? "good" : is(PICTURE.fair) ? "fair" : "poor";
    if (view.dataset.picture !== picture) view.dataset.picture = picture;
    setText(byId("picture-quality"), text("picture {quality}", { quality: translated(picture) }));
    this.link = link;
    this.picture = picture;
  }
}
