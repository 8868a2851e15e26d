// @ts-check
/** What the console knows of the robot: its topics, its joints, and which key moves what. */

import { CAMERA_ACTIONS, LOOK_ACTIONS } from "./camera_actions.js";
import { POSE_ACTIONS, TOOL_ACTIONS } from "./tool_actions.js";

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
 * @typedef {object} JointMotion  Moves joints of one node while it is held.
 * @property {"joints"} kind
 * @property {string} node
 * @property {string[]} joints    For flippers both; the chosen side decides which of them move.
 * @property {1 | -1} direction   Of the joint's velocity.
 *
 * @typedef {object} DriveMotion  Drives the tracks while it is held.
 * @property {"drive"} kind
 * @property {"linear" | "angular"} axis
 * @property {1 | -1} direction
 *
 * @typedef {object} SideChoice   Restricts flipper motions to one side while it is held.
 * @property {"side"} kind
 * @property {"left" | "right"} side
 *
 * @typedef {object} PresetMotion  Moves the flippers to a preset while it is held.
 * @property {"preset"} kind
 * @property {number} index       In the list of presets that the robot announces.
 *
 * @typedef {import("./tool_actions.js").ToolMotion} ToolMotion
 * @typedef {import("./tool_actions.js").PoseMotion} PoseMotion
 *
 * @typedef {import("./camera_actions.js").ZoomMotion} ZoomMotion
 *
 * @typedef {JointMotion | DriveMotion | SideChoice | PresetMotion | ToolMotion | PoseMotion | ZoomMotion} Motion
 * @typedef {Motion & {code: string, cap: string, label: string, amount?: number}} Action
 *   `code`: key position (KeyboardEvent.code); `cap`: what a US keyboard shows there; `label`: what it does;
 *   `amount`: how far it is held, 0 to 1 (default).
 */

/** @typedef {{name: string, label: string, metres?: boolean}} Joint */

/** @type {Joint[]} */
export const ARM_JOINTS = [
  { name: "turret_joint", label: "turret" },
  { name: "shoulder_joint", label: "shoulder" },
  { name: "telescope_joint", label: "telescope", metres: true },
  { name: "elbow_joint", label: "elbow" },
  { name: "forearm_roll_joint", label: "forearm roll" },
  { name: "wrist_pitch_joint", label: "wrist pitch" },
  { name: "gripper_roll_joint", label: "gripper roll" },
];

/** Joint by which gripper_teleop opens and closes all fingers together. */
export const GRIPPER_JOINT = "gripper";

/** Joints whose angle shows how far the gripper is open. */
export const FINGER_BASES = ["left_finger_base_joint", "right_finger_base_joint"];

/** So many presets have a key: Digit1, Digit2, … */
export const PRESET_KEYS = 7;

/** @param {string} side */
export const fingerJoints = (side) => ["base", "middle", "tip"].map((part) => `${side}_finger_${part}_joint`);

/** @param {string} end */
export const flipperJoints = (end) => ["left", "right"].map((side) => `${end}_${side}_flipper_joint`);

/**
 * @param {string} joint
 * @param {1 | -1} direction
 * @param {string} code
 * @param {string} cap
 * @param {string} label
 * @returns {Action}
 */
const arm = (joint, direction, code, cap, label) => ({
  kind: "joints", node: "arm_teleop", joints: [joint], direction, code, cap, label,
});

/**
 * @param {string} end
 * @param {1 | -1} direction
 * @param {string} code
 * @param {string} cap
 * @param {string} label
 * @returns {Action}
 */
const flippers = (end, direction, code, cap, label) => ({
  kind: "joints", node: "flipper_teleop", joints: flipperJoints(end), direction, code, cap, label,
});

/**
 * @param {1 | -1} direction
 * @param {string} code
 * @param {string} cap
 * @param {string} label
 * @returns {Action}
 */
const gripper = (direction, code, cap, label) => ({
  kind: "joints", node: "gripper_teleop", joints: [GRIPPER_JOINT], direction, code, cap, label,
});

/**
 * @param {"linear" | "angular"} axis
 * @param {1 | -1} direction
 * @param {string} code
 * @param {string} cap
 * @param {string} label
 * @returns {Action}
 */
const drive = (axis, direction, code, cap, label) => ({ kind: "drive", axis, direction, code, cap, label });

/**
 * @param {number} index
 * @returns {[string, Action]}
 */
const preset = (index) => [
  `preset:${index}`,
  { kind: "preset", index, code: `Digit${index + 1}`, cap: String(index + 1), label: `preset ${index + 1}` },
];

/**
 * Everything that can be held, by name. Pitch joints turn about +y, so their positive direction is down.
 * @type {Record<string, Action>}
 */
export const ACTIONS = {
  "drive:forward": drive("linear", 1, "KeyW", "W", "ahead"),
  "drive:left": drive("angular", 1, "KeyA", "A", "left"),
  "drive:back": drive("linear", -1, "KeyS", "S", "back"),
  "drive:right": drive("angular", -1, "KeyD", "D", "right"),
  "turret:left": arm("turret_joint", 1, "KeyJ", "J", "left"),
  "turret:right": arm("turret_joint", -1, "KeyL", "L", "right"),
  "shoulder:up": arm("shoulder_joint", -1, "KeyI", "I", "up"),
  "shoulder:down": arm("shoulder_joint", 1, "KeyK", "K", "down"),
  "telescope:in": arm("telescope_joint", -1, "KeyU", "U", "in"),
  "telescope:out": arm("telescope_joint", 1, "KeyO", "O", "out"),
  "elbow:up": arm("elbow_joint", -1, "KeyP", "P", "up"),
  "elbow:down": arm("elbow_joint", 1, "Semicolon", ";", "down"),
  "forearm_roll:left": arm("forearm_roll_joint", -1, "KeyN", "N", "left"),
  "forearm_roll:right": arm("forearm_roll_joint", 1, "KeyM", "M", "right"),
  "wrist_pitch:up": arm("wrist_pitch_joint", -1, "BracketLeft", "[", "up"),
  "wrist_pitch:down": arm("wrist_pitch_joint", 1, "Quote", "'", "down"),
  "gripper_roll:left": arm("gripper_roll_joint", -1, "Digit9", "9", "left"),
  "gripper_roll:right": arm("gripper_roll_joint", 1, "Digit0", "0", "right"),
  "gripper:close": gripper(-1, "Comma", ",", "close"),
  "gripper:open": gripper(1, "Period", ".", "open"),
  "front:up": flippers("front", 1, "KeyR", "R", "up"),
  "front:down": flippers("front", -1, "KeyF", "F", "down"),
  "rear:up": flippers("rear", 1, "KeyT", "T", "up"),
  "rear:down": flippers("rear", -1, "KeyG", "G", "down"),
  "side:left": { kind: "side", side: "left", code: "KeyQ", cap: "Q", label: "left" },
  "side:right": { kind: "side", side: "right", code: "KeyE", cap: "E", label: "right" },
  ...Object.fromEntries(Array.from({ length: PRESET_KEYS }, (_, index) => preset(index))),
  ...POSE_ACTIONS,
  ...TOOL_ACTIONS,
  ...LOOK_ACTIONS,
  ...CAMERA_ACTIONS,
};

/**
 * @typedef {"slower" | "faster" | "stop" | "estop" | "mode" | "drive_mode" | "camera_mode" | "frame" | "hold" | "guard" | "view"
 *   | "keys" | import("./camera_actions.js").LampCommand} Command
 */

/** What is done once when its key goes down. @type {Record<Command, import("./tool_actions.js").Key>} */
export const COMMANDS = {
  estop: { code: "Escape", cap: "Esc", label: "e-stop" },
  stop: { code: "Space", cap: "Space", label: "stop all" },
  slower: { code: "Minus", cap: "-", label: "slower" },
  faster: { code: "Equal", cap: "=", label: "faster" },
  mode: { code: "Tab", cap: "Tab", label: "JOINT or CARTESIAN mode" },
  drive_mode: { code: "Backquote", cap: "`", label: "DRIVE mode" },
  camera_mode: { code: "Enter", cap: "Enter", label: "CAMERA mode" },
  frame: { code: "KeyY", cap: "Y", label: "next frame" },
  hold: { code: "KeyH", cap: "H", label: "hold the tool" },
  guard: { code: "Backslash", cap: "\\", label: "proximity guard" },
  view: { code: "Digit8", cap: "8", label: "next camera" },
  keys: { code: "Slash", cap: "?", label: "list of keys" },
  "lamps:front": { code: "Home", cap: "Home", label: "front lamps" },
  "lamps:rear": { code: "End", cap: "End", label: "rear lamps" },
  "lamps:turret": { code: "Insert", cap: "Ins", label: "turret's lamp" },
  "lamps:gripper": { code: "Delete", cap: "Del", label: "gripper's lamp" },
};
