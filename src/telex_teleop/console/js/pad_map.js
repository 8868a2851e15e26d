// @ts-check
/** What the controls of a gamepad do: the file that the robot's joystick node reads, in the words of the console. */

import { LAMPS } from "./camera_actions.js";
import { ACTIONS } from "./robot.js";

/**
 * @typedef {any} JoyAction  `{kind, …}`, as the video server tells it.
 *
 * @typedef {object} Binding
 * @property {number} deadzone        Share of the way that is rest.
 * @property {JoyAction} [action]     Of a button.
 * @property {JoyAction} [positive]   Of a stick's right or lower end,
 * @property {JoyAction} [negative]   and of the other one.
 * @property {number} [expo]          Share of the cubic part of a stick's response.
 * @property {number} [scale]         Of the full rate at the end of a stick's way.
 *
 * @typedef {Record<string, Binding>} Layer  By the name of the control.
 * @typedef {{name: string, arm_mode: string, plain: Layer, shifted: Layer}} PadMode
 * @typedef {{enable: string, shift: string, modes: PadMode[]}} PadMap
 */

const COMMANDS = /** @type {Record<string, string>} */ ({
  "stop": "stop", "e-stop": "estop", "release e-stop": "release", "faster": "faster", "slower": "slower", "mode": "next_mode",
  "frame": "frame", "hold tool": "hold", "proximity guard": "guard",
});

const TOOL = /** @type {Record<string, [string, string]>} */ ({
  x: ["linear", "x"], y: ["linear", "y"], z: ["linear", "z"], roll: ["angular", "x"], pitch: ["angular", "y"], yaw: ["angular", "z"],
});

/** @returns {Promise<PadMap>} */
export async function fetchPadMap() {
  const reply = await fetch("/joy_map.json", { cache: "no-store" });
  if (!reply.ok) throw new Error(`the video server says ${reply.status}`);
  return reply.json();
}

/** @param {string[]} some @param {string[]} others */
const same = (some, others) => some.length === others.length && some.every((each) => others.includes(each));

/**
 * Name of the console's action or command that a pad's action is; empty if the console has none.
 * @param {JoyAction} wanted
 * @param {string[]} presets  Names of the flippers' presets, as the robot announces them.
 * @returns {string}
 */
export function nameOf(wanted, presets) {
  const find = (/** @type {(action: any) => boolean} */ is) =>
    Object.keys(ACTIONS).find((name) => !name.startsWith("camera_") && is(ACTIONS[name])) ?? "";
  switch (wanted.kind) {
    case "command":
      return COMMANDS[wanted.name] ?? "";
    case "drive":
      return find(({ kind, axis, direction }) => kind === "drive" && wanted[axis] === direction);
    case "jog":
      return find(({ kind, node, joints, direction }) =>
        kind === "joints" && node === `${wanted.node}_teleop` && same(joints, wanted.joints) && direction === wanted.sign);
    case "tool": {
      const [part, axis] = TOOL[wanted.axis];
      return find((action) => action.kind === "tool" && action.part === part && action.axis === axis && action.direction === wanted.sign);
    }
    case "zoom":
      return find(({ kind, direction }) => kind === "zoom" && direction === wanted.sign);
    case "pose":
      return find(({ kind, pose }) => kind === "pose" && pose === wanted.name);
    case "side":
      return `side:${wanted.name}`;
    case "preset": {
      const index = presets.indexOf(wanted.name);
      return `preset:${index}` in ACTIONS ? `preset:${index}` : "";
    }
    case "lamps":
      return Object.keys(LAMPS).find((name) => same(LAMPS[/** @type {keyof typeof LAMPS} */ (name)].lamps, wanted.names)) ?? "";
    default:
      return "";
  }
}

/**
 * What a control demands.
 * @param {Binding} binding
 * @param {number} value  -1 to 1
 * @returns {{action: JoyAction, amount: number}}  Amount 0 at rest, up to 1.
 */
export function demand({ action, positive, negative, deadzone, expo = 0, scale = 1 }, value) {
  const way = Math.max(0, (Math.abs(value) - deadzone) / (1 - deadzone));
  if (action !== undefined) return { action, amount: value > 0 ? Math.min(1, way) : 0 };
  const amount = Math.min(1, scale * ((1 - expo) * way + expo * way ** 3));
  return { action: value > 0 ? positive : negative, amount };
}
