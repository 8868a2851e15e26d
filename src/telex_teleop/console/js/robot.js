// @ts-check
/** What the console knows of any robot, its nodes; and what it is told of the one that it shows. */

/** Nodes that take joint commands; their topics are `<node>/delta_joint_cmds`, `/speed_scale`, `/status`. */
export const JOINT_NODES = ["arm_teleop", "gripper_teleop", "flipper_teleop"];

/** Node that takes presets, on `<node>/preset_cmds`, and says on `<node>/presets` which there are. */
export const FLIPPER_NODE = "flipper_teleop";

export const TRACK_NODE = "track_teleop";

export const TYPES = {
  bool: "std_msgs/Bool",
  flipperPresetHold: "telex_msgs/FlipperPresetHold",
  flipperPresets: "telex_msgs/FlipperPresets",
  jointJog: "control_msgs/JointJog",
  jointStates: "sensor_msgs/JointState",
  jointStatus: "telex_msgs/JointTeleopStatus",
  number: "std_msgs/Float64",
  simStatus: "telex_msgs/SimStatus",
  trackStatus: "telex_msgs/TrackTeleopStatus",
  twist: "geometry_msgs/Twist",
};

/**
 * What the video server tells of the robot, from its URDF and its nodes' parameters.
 * @typedef {{name: string, measured_by: string[], geometry: import("./gripper.js").Geometry | null}} GripperFacts  `name`: by which all
 *   its joints are moved together; `measured_by`: those whose mean is its value.
 * @typedef {{axles: string[], radius: number, half_width: number}} TrackFacts  Joints that turn tracks or wheels; in m.
 * @typedef {object} Facts
 * @property {Record<string, {zoom_max: number | null}>} cameras
 * @property {Record<"arm" | "gripper" | "flipper", string[]> | null} moves  Joints that each node moves; null: it is not said.
 * @property {Record<"left" | "right", string[]>} sides   Flippers and fingers of each.
 * @property {GripperFacts | null} gripper
 * @property {string | null} odometry  Topic; null: it cannot drive.
 * @property {TrackFacts | null} [tracks]
 * @property {string | null} [tool]  Link that is the arm's.
 * @property {Record<string, any>} [equipment]
 * @property {Record<string, any>} [training_aids]  What stands in for equipment that it lacks, in practice.
 */

/** Of a robot of which nothing is said; where it drives, it tells so as track_teleop has it by default. @type {Facts} */
export const UNKNOWN = { cameras: {}, moves: null, sides: { left: [], right: [] }, gripper: null, odometry: "track_controller/odom" };

/** Which robot this page's address asks for, and nothing else of it: its token is not for everybody. @param {URLSearchParams} given */
export const whichRobot = (given) => new URLSearchParams([...given].filter(([name]) => name === "robot"));

/** @param {URLSearchParams} given  @returns {Promise<Facts>} */
export async function fetchRobot(given) {
  const reply = await fetch(`/robot.json?${whichRobot(given)}`, { cache: "no-store" });
  if (!reply.ok) throw new Error(`the video server says ${reply.status}`);
  return { ...UNKNOWN, ...(await reply.json()) };
}

/**
 * The robot's description; null: there is none yet.
 * @param {URLSearchParams} given  With the token, which it needs as pictures do.
 * @returns {Promise<string | null>}
 */
export async function fetchUrdf(given) {
  const query = new URLSearchParams([...given].filter(([name]) => ["robot", "token", "role"].includes(name)));
  const reply = await fetch(`/robot.urdf?${query}`, { cache: "no-store" });
  if (!reply.ok) throw new Error(`the video server says ${reply.status}`);
  return reply.status === 204 ? null : reply.text();
}

/** Whether what two answers say that can be moved is the same. @param {Facts} a @param {Facts} b */
export function isSameRobot(a, b) {
  const [one, other] = [a, b].map(({ cameras: _, equipment: __, training_aids: ___, ...moved }) => JSON.stringify(moved));
  return one === other;
}

/** How often (once a second) it is asked at most how a robot is equipped of which nothing is told. */
const ASKED_AT_MOST = 30;

/** Asks what the robot is, anew with each connection: a simulator tells how it is equipped once it stands in its scene. */
export class RobotWatch {
  /**
   * @param {URLSearchParams} given
   * @param {(facts: Facts) => void} told
   */
  constructor(given, told) {
    this._given = given;
    this._told = told;
    /** How often it may be asked again. */
    this._left = 0;
    this._isAsking = false;
  }

  /** Call it when the bridge is connected. */
  async connected() {
    this._left = ASKED_AT_MOST;
    await this._ask();
  }

  /** Call it with each status of the simulator; what was told before the first may be of the one before. */
  async hearStatus() {
    if (this._left === 0 || this._isAsking) return;
    this._left -= 1;
    if (await this._ask()) this._left = 0;
  }

  /** Returns whether it is told how the robot is equipped. */
  async _ask() {
    this._isAsking = true;
    try {
      const facts = await fetchRobot(this._given);
      this._told(facts);
      return Object.keys({ ...facts.equipment, ...facts.training_aids }).length > 0;
    } catch {
      return false; // what was known before still holds
    } finally {
      this._isAsking = false;
    }
  }
}
