// @ts-check
/** The arm by its tool: mode, frame, commands, and what the panel shows of it. */

import { onClick } from "./buttons.js";
import { text, translated } from "./language.js";
import { all, byId, element, fixed, holdButton, row, rowsOf, setText } from "./panels.js";

/** Part and axis of a twist for each axis of the tool. @type {Record<string, ["linear" | "angular", "x" | "y" | "z"]>} */
const TWIST = {
  x: ["linear", "x"], y: ["linear", "y"], z: ["linear", "z"], roll: ["angular", "x"], pitch: ["angular", "y"], yaw: ["angular", "z"],
};

const NODE = "arm_teleop";

/** What the arm says of what it comes near to. */
const GUARDED = /(slowed|stopped|the base drives): [^;]* is -?\d+ mm from /;

export const TOOL_TYPES = {
  cartesianStatus: "telex_msgs/CartesianTeleopStatus",
  name: "std_msgs/String",
  twist: "geometry_msgs/TwistStamped",
};

/** @typedef {"JOINT" | "CARTESIAN"} Mode */

/** Sends twists and names of poses while their actions are held, and the end of them. */
export class ToolCommander {
  /**
   * @param {import("./bridge.js").Bridge} bridge
   * @param {(name: string) => string} topic
   * @param {() => boolean} congested  Whether motion would queue behind old motion.
   * @param {(sentence: string) => void} warn
   */
  constructor(bridge, topic, congested, warn) {
    this._bridge = bridge;
    this._topic = topic;
    this._congested = congested;
    this._warn = warn;
    /** @type {any} */
    this._status = null;
    this._moving = false;
    this._toPose = "";
    /** Frame that the operator chose, empty for the node's own default. */
    this.frame = "";
  }

  /** Whether commands have to be sent now: motion, or its end. */
  get busy() {
    return this._moving || this._toPose !== "";
  }

  advertise() {
    this._bridge.advertise(this._topic(`${NODE}/delta_twist_cmds`), TOOL_TYPES.twist, { held: true });
    this._bridge.advertise(this._topic(`${NODE}/named_pose_cmds`), TOOL_TYPES.name, { held: true });
  }

  /** @param {any} status  telex_msgs/CartesianTeleopStatus */
  setStatus(status) {
    this._status = status;
    if (!status.frames.includes(this.frame)) this.frame = status.default_frame;
  }

  /** The connection is gone, and with it the bridge has stopped what moved. */
  disconnected() {
    this._moving = false;
    this._toPose = "";
  }

  /** @param {import("./vocabulary.js").Demand[]} held */
  update(held) {
    this._commandTwist(held);
    this._commandPose(held);
  }

  /** @param {import("./vocabulary.js").Demand[]} held */
  _commandTwist(held) {
    const twist = { linear: { x: 0, y: 0, z: 0 }, angular: { x: 0, y: 0, z: 0 } };
    for (const action of held) {
      if (action.kind !== "tool") continue;
      const [part, axis] = TWIST[action.axis];
      twist[part][axis] += action.sign * (action.amount ?? 1);
    }
    const parts = /** @type {("linear" | "angular")[]} */ (["linear", "angular"]);
    const wanted = parts.some((part) => Object.values(twist[part]).some((rate) => rate !== 0));
    if ((!wanted && !this._moving) || (wanted && this._congested())) return;
    if (wanted && this._status === null) {
      this._warn(text("{node} has not said yet how fast the tool may move: is it running?", { node: NODE }));
      return;
    }
    const limits = { linear: this._status?.max_linear ?? 0, angular: this._status?.max_angular ?? 0 };
    for (const part of parts) {
      for (const axis of /** @type {("x" | "y" | "z")[]} */ (["x", "y", "z"])) {
        twist[part][axis] = Math.max(-1, Math.min(1, twist[part][axis])) * limits[part];
      }
    }
    const sent = this._bridge.publish(this._topic(`${NODE}/delta_twist_cmds`), {
      header: { frame_id: this.frame }, twist,
    });
    if (sent) this._moving = wanted;
  }

  /** @param {import("./vocabulary.js").Demand[]} held */
  _commandPose(held) {
    const asked = held.flatMap((action) => (action.kind === "pose" ? [action.name] : []));
    // Two poses contradict each other, as the two keys of a joint do: no motion.
    const pose = asked.length === 1 ? asked[0] : "";
    if ((pose === "" && this._toPose === "") || (pose !== "" && this._congested())) return;
    if (this._bridge.publish(this._topic(`${NODE}/named_pose_cmds`), { data: pose })) this._toPose = pose;
  }
}

/** Shows mode, frame and tool in the arm's panel, and asks the arm for another mode. */
export class ToolPanel {
  /**
   * @param {import("./vocabulary.js").Vocabulary} vocabulary
   * @param {ToolCommander} commander
   * @param {import("./robot_client.js").RobotClient} robot
   * @param {(reason: string) => void} letGo  Releases everything that is held.
   */
  constructor(vocabulary, commander, robot, letGo) {
    this._commander = commander;
    this._robot = robot;
    this._letGo = letGo;
    /** Of the arm, as its status says. @type {Mode} */
    this.mode = "JOINT";
    this._holdsTool = false;
    this._guard = true;
    /** Whether the arm comes near to something that slows or stops it, or would. */
    this.isGuarded = false;
    /** Called when the arm is in another mode. */
    this.changed = () => {};
    /** @type {string[]} */
    this._frames = [];
    /** What shows where the tool is, by axis. @type {Record<string, HTMLElement>} */
    this._values = Object.fromEntries(Object.keys(TWIST).map((axis) => [axis, element("span", "num", "–")]));
    for (const [axis, value] of Object.entries(this._values)) value.id = `tool_${axis}-value`;
    for (const actions of rowsOf(vocabulary.find("tool"))) {
      byId("tool-rows").append(row("", text(actions[0].row), this._values[actions[0].does.axis], ...actions.map(holdButton)));
    }
    this._poses = vocabulary.find("pose").map((action) => ({ pose: action.does.name, button: holdButton(action) }));
    byId("pose-buttons").append(...this._poses.map(({ button }) => button));
    this._show();
  }

  /** Whether the arm says that it keeps away from what is near. */
  get guards() {
    return this._frames.length > 0 && this._guard;
  }

  /** @param {any} status  telex_msgs/JointTeleopStatus of arm_teleop */
  setArmStatus(status) {
    const mode = status.mode === "CARTESIAN" ? "CARTESIAN" : "JOINT";
    if (mode !== this.mode) {
      this._letGo(text("the arm is in {mode} mode now", { mode: text(mode) }));
      this.mode = mode;
      this.changed();
    }
    this.isGuarded = GUARDED.test(status.notice);
    setText(byId("arm-hud"), status.notice);
    this._show();
  }

  /** @param {any} status  telex_msgs/CartesianTeleopStatus */
  setStatus(status) {
    this._frames = status.frames;
    this._holdsTool = status.holds_tool;
    this._guard = status.guard;
    this._commander.setStatus(status);
    const { position, orientation } = status.tool;
    const { x, y, z, w } = orientation;
    const angles = {
      roll: Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
      pitch: Math.asin(Math.max(-1, Math.min(1, 2 * (w * y - z * x)))),
      yaw: Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
    };
    for (const axis of /** @type {("x" | "y" | "z")[]} */ (["x", "y", "z"])) {
      setText(this._values[axis], `${fixed(position[axis] * 1000, 0)} mm`);
    }
    for (const [name, angle] of Object.entries(angles)) {
      setText(this._values[name], `${fixed((angle * 180) / Math.PI, 1)}°`);
    }
    for (const { pose, button } of this._poses) button.disabled = !status.poses.includes(pose);
    this._show();
  }

  /** @param {Mode} mode */
  setMode(mode) {
    this._letGo(text("{mode} mode", { mode: text(mode) }));
    this._ask("set_mode", { mode });
  }

  /** @param {string} [frame]  The next one if none is named. */
  setFrame(frame) {
    if (this._frames.length === 0) return;
    const next = this._frames[(this._frames.indexOf(this._commander.frame) + 1) % this._frames.length];
    this._letGo(text("frame changed"));
    this._commander.frame = frame ?? next;
    this._show();
  }

  toggleHold() {
    this._ask("hold_tool", { data: !this._holdsTool });
  }

  toggleGuard() {
    this._ask("set_proximity_guard", { data: !this._guard });
  }

  /** @param {string} name @param {object} args */
  _ask(name, args) {
    const service = `${NODE}/${name}`;
    this._robot.request(service, args, (why) => `${service}: ${why}`);
  }

  _show() {
    for (const button of all("[data-frame]")) {
      const frame = this._frames[Number(button.dataset.frame)];
      button.hidden = frame === undefined;
      setText(button, translated((frame ?? "").replace(/_link$/, "")));
      button.setAttribute("aria-checked", String(frame === this._commander.frame));
    }
    byId("hold-tool").setAttribute("aria-checked", String(this._holdsTool));
    byId("guard").setAttribute("aria-checked", String(this._guard));
  }

  /** Let the panel's switches be clicked. */
  listen() {
    for (const button of all("[data-frame]")) {
      onClick(button, () => this.setFrame(this._frames[Number(button.dataset.frame)]));
    }
    onClick(byId("hold-tool"), () => this.toggleHold());
    onClick(byId("guard"), () => this.toggleGuard());
  }
}
