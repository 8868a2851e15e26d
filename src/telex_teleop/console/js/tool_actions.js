// @ts-check
/** What can be held to move the arm by its tool, or to a named pose, and by which key. */

/**
 * @typedef {object} ToolMotion  Moves the tool along or about an axis of the chosen frame, in CARTESIAN mode.
 * @property {"tool"} kind
 * @property {"linear" | "angular"} part
 * @property {"x" | "y" | "z"} axis
 * @property {1 | -1} direction
 *
 * @typedef {object} PoseMotion   Moves the arm to a named pose, in both modes.
 * @property {"pose"} kind
 * @property {string} pose
 *
 * @typedef {{code: string, cap: string, label: string}} Key
 */

/**
 * @param {"linear" | "angular"} part
 * @param {"x" | "y" | "z"} axis
 * @param {1 | -1} direction
 * @param {string} code
 * @param {string} cap
 * @param {string} label
 * @returns {ToolMotion & Key}
 */
const tool = (part, axis, direction, code, cap, label) => ({
  kind: "tool", part, axis, direction, code, cap, label,
});

/**
 * @param {string} pose
 * @param {string} code
 * @param {string} cap
 * @param {string} label
 * @returns {PoseMotion & Key}
 */
const toPose = (pose, code, cap, label) => ({ kind: "pose", pose, code, cap, label });

/**
 * The keys of the joints that do nearly the same: turret, shoulder, telescope, wrist, rolls. Of the frame's axes x points
 * ahead, y to the left, z up, so a pitch is up when it turns about -y.
 * @type {Record<string, ToolMotion & Key>}
 */
export const TOOL_ACTIONS = {
  "tool_x:back": tool("linear", "x", -1, "KeyU", "U", "back"),
  "tool_x:ahead": tool("linear", "x", 1, "KeyO", "O", "ahead"),
  "tool_y:left": tool("linear", "y", 1, "KeyJ", "J", "left"),
  "tool_y:right": tool("linear", "y", -1, "KeyL", "L", "right"),
  "tool_z:up": tool("linear", "z", 1, "KeyI", "I", "up"),
  "tool_z:down": tool("linear", "z", -1, "KeyK", "K", "down"),
  "tool_pitch:up": tool("angular", "y", -1, "BracketLeft", "[", "up"),
  "tool_pitch:down": tool("angular", "y", 1, "Quote", "'", "down"),
  "tool_yaw:left": tool("angular", "z", 1, "KeyN", "N", "left"),
  "tool_yaw:right": tool("angular", "z", -1, "KeyM", "M", "right"),
  "tool_roll:left": tool("angular", "x", -1, "Digit9", "9", "left"),
  "tool_roll:right": tool("angular", "x", 1, "Digit0", "0", "right"),
};

/** @type {Record<string, PoseMotion & Key>} */
export const POSE_ACTIONS = {
  "pose:stow": toPose("stow", "KeyZ", "Z", "stow"),
  "pose:drive": toPose("drive", "KeyX", "X", "drive"),
  "pose:ready": toPose("ready", "KeyC", "C", "ready"),
  "pose:look_front": toPose("look_front", "KeyV", "V", "look"),
  "pose:floor_pick": toPose("floor_pick", "KeyB", "B", "pick"),
};

/** Rows of the panel: what is moved, and the value that shows it. */
export const TOOL_ROWS = [
  { name: "tool_x", label: "x ahead", ways: ["back", "ahead"] },
  { name: "tool_y", label: "y left", ways: ["left", "right"] },
  { name: "tool_z", label: "z up", ways: ["up", "down"] },
  { name: "tool_pitch", label: "pitch", ways: ["up", "down"] },
  { name: "tool_yaw", label: "yaw", ways: ["left", "right"] },
  { name: "tool_roll", label: "roll", ways: ["left", "right"] },
];
