// @ts-check
/** What can be held to move the camera on the turret, and which lamps there are. */

/**
 * @typedef {object} ZoomMotion  Changes the zoom of the turret's camera while it is held.
 * @property {"zoom"} kind
 * @property {1 | -1} direction
 *
 * @typedef {import("./tool_actions.js").Key} Key
 * @typedef {import("./robot.js").JointMotion} JointMotion
 */

/** The camera that can be moved. */
export const MOVED_CAMERA = "turret";

const PAN = "turret_camera_pan_joint";
const TILT = "turret_camera_tilt_joint";

export const CAMERA_JOINTS = [
  { name: PAN, label: "pan" },
  { name: TILT, label: "tilt" },
];

/**
 * @param {string} joint
 * @param {1 | -1} direction
 * @param {string} code
 * @param {string} cap
 * @param {string} label
 * @returns {JointMotion & Key}
 */
const turn = (joint, direction, code, cap, label) => ({
  kind: "joints", node: "arm_teleop", joints: [joint], direction, code, cap, label,
});

/**
 * @param {1 | -1} direction
 * @param {string} code
 * @param {string} cap
 * @param {string} label
 * @returns {ZoomMotion & Key}
 */
const zoom = (direction, code, cap, label) => ({ kind: "zoom", direction, code, cap, label });

/** In every mode. @type {Record<string, (JointMotion | ZoomMotion) & Key>} */
export const LOOK_ACTIONS = {
  "look:left": turn(PAN, 1, "ArrowLeft", "←", "camera left"),
  "look:right": turn(PAN, -1, "ArrowRight", "→", "camera right"),
  "look:up": turn(TILT, -1, "ArrowUp", "↑", "camera up"),
  "look:down": turn(TILT, 1, "ArrowDown", "↓", "camera down"),
  "look:near": zoom(1, "PageUp", "PgUp", "zoom in"),
  "look:far": zoom(-1, "PageDown", "PgDn", "zoom out"),
};

/** In CAMERA mode, with the keys that move the arm in the others. @type {Record<string, (JointMotion | ZoomMotion) & Key>} */
export const CAMERA_ACTIONS = {
  "camera_pan:left": turn(PAN, 1, "KeyJ", "J", "left"),
  "camera_pan:right": turn(PAN, -1, "KeyL", "L", "right"),
  "camera_tilt:up": turn(TILT, -1, "KeyI", "I", "up"),
  "camera_tilt:down": turn(TILT, 1, "KeyK", "K", "down"),
  "camera_zoom:wider": zoom(-1, "KeyU", "U", "zoom out"),
  "camera_zoom:nearer": zoom(1, "KeyO", "O", "zoom in"),
};

/** @typedef {"lamps:front" | "lamps:rear" | "lamps:turret" | "lamps:gripper"} LampCommand */

/** Lamps that are switched together. @type {Record<LampCommand, {label: string, lamps: string[]}>} */
export const LAMPS = {
  "lamps:front": { label: "front", lamps: ["front_left", "front_right"] },
  "lamps:rear": { label: "rear", lamps: ["rear_left", "rear_right"] },
  "lamps:turret": { label: "turret", lamps: ["turret_camera"] },
  "lamps:gripper": { label: "gripper", lamps: ["gripper"] },
};
