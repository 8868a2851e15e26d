// @ts-check
/** Turns held actions into commands: at once on every change, 50 times a second while held, a zero at the end. */

import { text } from "./language.js";
import { FLIPPER_NODE, JOINT_NODES, TRACK_NODE, TYPES } from "./robot.js";

/** Period (ms) of the commands while something is held. */
export const COMMAND_PERIOD = 20;

/** Bytes in the browser's send buffer above which the link is congested: motion is not queued behind old motion. */
const MAX_WAITING = 4096;

/** How often the zero of a released joint is sent while others move on: the next command may replace one that is under way. */
const ZEROS = 3;

/** Time (ms) for which a chosen speed scale counts before the nodes confirm it. */
const SPEED_CONFIRMED_AFTER = 500;

/** @typedef {{scale: number, min: number, max: number}} Speed */

export class Commander {
  /**
   * @param {import("./vocabulary.js").Vocabulary} vocabulary
   * @param {import("./bridge.js").Bridge} bridge
   * @param {(name: string) => string} topic     Gives a name inside the robot's namespace its global form.
   * @param {(sentence: string) => void} warn    Says why a held action has no effect.
   * @param {import("./robot.js").Facts} facts
   */
  constructor(vocabulary, bridge, topic, warn, facts) {
    this._speedStep = vocabulary.speedStep;
    this._flippers = vocabulary.flippers;
    this._sides = facts.sides;
    this._gripper = facts.gripper;
    this._bridge = bridge;
    this._topic = topic;
    this._warn = warn;
    /** Largest velocities that the nodes announced: node, joint. @type {Map<string, Map<string, number>>} */
    this._maxVelocity = new Map();
    /** @type {{linear: number, angular: number} | null} */
    this._maxDrive = null;
    /** @type {Map<string, Speed>} */
    this._speeds = new Map();
    this._chosenSpeed = { scale: 0, at: -Infinity };
    /** Joints that the last commands moved, by node, and how many zeros each is still to get. @type {Map<string, Map<string, number>>} */
    this._moving = new Map(JOINT_NODES.map((node) => [node, new Map()]));
    this._driving = false;
    /** Names of the flipper presets, in the order of their keys. @type {string[]} */
    this.presets = [];
    this._leading = false;
    /** Side of the flippers that move, unless a side key is held. @type {"left" | "both" | "right"} */
    this.side = "both";
  }

  /** Announce the topics that commands go to. */
  advertise() {
    for (const node of JOINT_NODES) {
      this._bridge.advertise(this._topic(`${node}/delta_joint_cmds`), TYPES.jointJog, { held: true });
      this._bridge.advertise(this._topic(`${node}/speed_scale`), TYPES.number);
    }
    this._bridge.advertise(this._topic(`${FLIPPER_NODE}/preset_cmds`), TYPES.flipperPresetHold, { held: true });
    this._bridge.advertise(this._topic(`${TRACK_NODE}/cmd_vel`), TYPES.twist, { held: true });
    this._bridge.advertise(this._topic(`${TRACK_NODE}/speed_scale`), TYPES.number);
  }

  /**
   * Take the limits from a joint node's status.
   * @param {string} node
   * @param {any} status  telex_msgs/JointTeleopStatus
   */
  setJointStatus(node, status) {
    /** @type {Map<string, number>} */
    const limits = new Map();
    status.joint_names.forEach((/** @type {string} */ joint, /** @type {number} */ index) => {
      const limit = status.max_velocity[index];
      if (limit > 0) limits.set(joint, limit);
    });
    this._maxVelocity.set(node, limits);
    this._setSpeed(node, status);
  }

  /**
   * Take the limits from the track node's status.
   * @param {any} status  telex_msgs/TrackTeleopStatus
   */
  setTrackStatus(status) {
    this._maxDrive = { linear: status.max_linear, angular: status.max_angular };
    this._setSpeed(TRACK_NODE, status);
  }

  /** Speed scales that the nodes announced, the chosen one while it is being taken over. */
  get speeds() {
    if (performance.now() - this._chosenSpeed.at < SPEED_CONFIRMED_AFTER) return [this._chosenSpeed.scale];
    return [...new Set([...this._speeds.values()].map(({ scale }) => scale))].sort((a, b) => a - b);
  }

  /**
   * Make everything slower or faster by a step.
   * @param {1 | -1} direction
   */
  changeSpeed(direction) {
    const speeds = this.speeds;
    if (speeds.length === 0) {
      this._warn(text("speed: no teleop node has said what it is yet"));
      return;
    }
    const base = direction > 0 ? speeds[speeds.length - 1] : speeds[0];
    const steps = base / this._speedStep;
    // Off-grid values (a minimum of 5 %) go to the next grid value in the direction asked for.
    const next = direction > 0 ? Math.floor(steps + 1 + 1e-6) : Math.ceil(steps - 1 - 1e-6);
    const min = Math.min(...[...this._speeds.values()].map((speed) => speed.min));
    const max = Math.max(...[...this._speeds.values()].map((speed) => speed.max));
    this._chosenSpeed = { scale: clamp(next * this._speedStep, min, max), at: performance.now() };
    for (const [node, speed] of this._speeds) {
      const data = clamp(this._chosenSpeed.scale, speed.min, speed.max);
      this._bridge.publish(this._topic(`${node}/speed_scale`), { data });
    }
  }

  /**
   * Send what the held actions ask for. Call on every change, and every COMMAND_PERIOD.
   * @param {import("./vocabulary.js").Demand[]} held
   */
  update(held) {
    for (const node of JOINT_NODES) this._commandJoints(node, this._wantedJoints(node, held));
    this._commandPreset(held);
    this._commandTracks(held);
  }

  /** End a preset that nobody holds here: a script's, or another operator's. */
  stopPresets() {
    this._sendPreset("", []);
  }

  /** Forget what is moving: the connection is gone, and with it the bridge has stopped it. */
  disconnected() {
    for (const joints of this._moving.values()) joints.clear();
    this._driving = this._leading = false;
  }

  /** Whether commands have to be sent now: motion, or its end. */
  get busy() {
    return this._driving || this._leading || [...this._moving.values()].some((joints) => joints.size > 0);
  }

  /**
   * @param {string} node
   * @param {any} status
   */
  _setSpeed(node, status) {
    this._speeds.set(node, {
      scale: status.speed_scale, min: status.min_speed_scale, max: status.max_speed_scale,
    });
  }

  /**
   * @param {string} node
   * @param {import("./vocabulary.js").Demand[]} held
   * @returns {Map<string, number>} Velocities of the joints that shall move.
   */
  _wantedJoints(node, held) {
    const side = this.sideOf(held);
    /** @type {Map<string, number>} */
    const directions = new Map();
    for (const action of held) {
      if (action.kind !== "jog" || `${action.node}_teleop` !== node) continue;
      for (const joint of action.joints) {
        if (node === FLIPPER_NODE && side !== "both" && !this._sides[side].includes(joint)) continue;
        directions.set(joint, (directions.get(joint) ?? 0) + action.sign * (action.amount ?? 1));
      }
    }
    /** @type {Map<string, number>} */
    const wanted = new Map();
    for (const [joint, direction] of directions) {
      if (direction === 0) continue; // both keys of a pair: no motion
      const limit = this._limitOf(node, joint);
      if (limit === undefined) {
        const isKnown = (this._maxVelocity.get(node)?.size ?? 0) > 0;
        this._warn(isKnown ? text("the robot has no {joint}", { joint }) : text("{node} has not said yet how fast {joint} may move: is it running?", { node, joint }));
      } else {
        wanted.set(joint, clamp(direction, -1, 1) * limit);
      }
    }
    return wanted;
  }

  /**
   * The side of the flippers that shall move: held keys win over the choice on the page.
   * @param {import("./vocabulary.js").Demand[]} held
   * @returns {"left" | "both" | "right"}
   */
  sideOf(held) {
    const sides = new Set();
    for (const action of held) if (action.kind === "side") sides.add(action.name);
    if (sides.size === 2) return "both";
    return sides.size === 1 ? [...sides][0] : this.side;
  }

  /**
   * @param {string} node
   * @param {string} joint
   * @returns {number | undefined}
   */
  _limitOf(node, joint) {
    const limits = this._maxVelocity.get(node);
    if (limits === undefined) return undefined;
    if (joint === this._gripper?.name && !limits.has(joint)) {
      const bases = this._gripper.measured_by.map((base) => limits.get(base)).filter((limit) => limit !== undefined);
      return bases.length > 0 ? Math.min(.../** @type {number[]} */ (bases)) : undefined;
    }
    return limits.get(joint);
  }

  /**
   * @param {string} node
   * @param {Map<string, number>} wanted
   */
  _commandJoints(node, wanted) {
    const moving = /** @type {Map<string, number>} */ (this._moving.get(node));
    const released = [...moving.keys()].filter((joint) => !wanted.has(joint));
    if (wanted.size === 0 && released.length === 0) return;
    if (released.length === 0 && this.congested) return;
    const sent = this._bridge.publish(this._topic(`${node}/delta_joint_cmds`), {
      header: {},
      joint_names: [...wanted.keys(), ...released],
      velocities: [...wanted.values(), ...released.map(() => 0)],
    });
    if (!sent) return;
    for (const joint of released) {
      const left = /** @type {number} */ (moving.get(joint)) - 1;
      // The last command of all stays the newest.
      if (left > 0 && wanted.size > 0) moving.set(joint, left);
      else moving.delete(joint);
    }
    for (const joint of wanted.keys()) moving.set(joint, ZEROS);
  }

  /** @param {import("./vocabulary.js").Demand[]} held */
  _commandPreset(held) {
    const asked = held.flatMap((action) => (action.kind === "preset" ? [action] : []));
    // Two presets contradict each other, as the two keys of a joint do: no motion.
    let name = asked.length === 1 ? this.presets[asked[0].index] ?? "" : "";
    if (asked.length === 1 && name === "") this._warn(text("the robot has no flipper preset {number}", { number: asked[0].index + 1 }));
    const side = this.sideOf(held);
    const joints = side === "both" ? [] : this._flippers.filter((joint) => this._sides[side].includes(joint));
    if (name !== "" && side !== "both" && joints.length === 0) {
      // Without names, a preset is for all flippers.
      this._warn(text("no flippers are known on the {side}", { side: text(side) }));
      name = "";
    }
    if ((name === "" && !this._leading) || (name !== "" && this.congested)) return;
    if (this._sendPreset(name, joints)) this._leading = name !== "";
  }

  /**
   * @param {string} preset
   * @param {string[]} joints  Empty for all.
   * @returns {boolean} Whether it was sent.
   */
  _sendPreset(preset, joints) {
    const message = { header: {}, preset, joint_names: joints };
    return this._bridge.publish(this._topic(`${FLIPPER_NODE}/preset_cmds`), message);
  }

  /** @param {import("./vocabulary.js").Demand[]} held */
  _commandTracks(held) {
    const command = { linear: 0, angular: 0 };
    for (const action of held) {
      if (action.kind !== "drive") continue;
      command.linear += action.linear * (action.amount ?? 1);
      command.angular += action.angular * (action.amount ?? 1);
    }
    const wanted = command.linear !== 0 || command.angular !== 0;
    if (wanted && this._maxDrive === null) {
      this._warn(text("{node} has not said yet how fast it may drive: is it running?", { node: TRACK_NODE }));
      return;
    }
    if ((!wanted && !this._driving) || (wanted && this.congested)) return;
    const { linear, angular } = this._maxDrive ?? { linear: 0, angular: 0 };
    const sent = this._bridge.publish(this._topic(`${TRACK_NODE}/cmd_vel`), {
      linear: { x: clamp(command.linear, -1, 1) * linear },
      angular: { z: clamp(command.angular, -1, 1) * angular },
    });
    if (sent) this._driving = wanted;
  }

  /** Whether motion would queue behind old motion. */
  get congested() {
    return this._bridge.waiting > MAX_WAITING;
  }
}

/**
 * @param {number} value
 * @param {number} min
 * @param {number} max
 */
function clamp(value, min, max) {
  return Math.min(max, Math.max(min, value));
}
