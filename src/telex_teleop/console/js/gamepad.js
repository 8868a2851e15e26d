// @ts-check
/** A gamepad of the browser's standard layout, or a joystick that is like one: sticks and buttons that hold actions. */

import { byId, setText } from "./panels.js";

/** @typedef {import("./keymap.js").Mode} Mode */
/** @typedef {import("./robot.js").Command} Command */

const DEAD_ZONE = 0.15; // share of a stick's way
const PRESSED = 0.15; // share of a trigger's way

/** Indices of the standard layout (W3C Gamepad, "remapping"). */
const BUTTON = {
  a: 0, b: 1, x: 2, y: 3, lb: 4, rb: 5, lt: 6, rt: 7, back: 8, start: 9, l3: 10, up: 12, down: 13, left: 14, right: 15,
};

/**
 * What an input does: names of actions for a stick's negative (left, up) and positive end, or for a button.
 * @typedef {{axes: ([string, string] | null)[], buttons: Partial<Record<keyof typeof BUTTON, string>>}} Layout
 */

/** @type {[string, string]} */
const PAN = ["look:left", "look:right"];
/** @type {[string, string]} */
const TILT = ["look:up", "look:down"];
/** In every mode; one press, one deed. No motion and no double press stands between the operator and the e-stop. */
const ALWAYS = { back: "drive_mode", start: "mode", l3: "estop" };

/** @type {Record<Mode, Layout>} */
export const PAD = {
  DRIVE: {
    axes: [["drive:left", "drive:right"], ["drive:forward", "drive:back"], PAN, TILT],
    buttons: {
      a: "slower", y: "faster", x: "side:left", b: "side:right", lb: "rear:up", rb: "front:up", lt: "rear:down", rt: "front:down",
      up: "preset:5", down: "preset:0", left: "preset:1", right: "preset:6",
    },
  },
  JOINT: {
    axes: [["turret:left", "turret:right"], ["shoulder:up", "shoulder:down"], ["forearm_roll:left", "forearm_roll:right"], ["elbow:up", "elbow:down"]],
    buttons: {
      x: "gripper:close", y: "gripper:open", lb: "gripper_roll:left", rb: "gripper_roll:right", lt: "telescope:in", rt: "telescope:out",
      up: "wrist_pitch:up", down: "wrist_pitch:down", left: "pose:stow", right: "pose:ready",
    },
  },
  CARTESIAN: {
    axes: [["tool_y:left", "tool_y:right"], ["tool_z:up", "tool_z:down"], ["tool_yaw:left", "tool_yaw:right"], ["tool_pitch:up", "tool_pitch:down"]],
    buttons: {
      x: "gripper:close", y: "gripper:open", b: "hold", lb: "tool_roll:left", rb: "tool_roll:right", lt: "tool_x:back", rt: "tool_x:ahead",
      up: "pose:look_front", down: "pose:stow", left: "pose:drive", right: "pose:ready",
    },
  },
  CAMERA: {
    axes: [null, ["look:near", "look:far"], PAN, TILT],
    buttons: { a: "lamps:front", b: "lamps:rear", x: "lamps:gripper", y: "lamps:turret", rb: "view" },
  },
};

export class GamepadInput {
  /**
   * @param {import("./held.js").Held} held
   * @param {() => boolean} mayPress
   * @param {() => Mode} mode
   * @param {Record<Command, () => void>} commands
   * @param {(reason: string) => void} letGo
   */
  constructor(held, mayPress, mode, commands, letGo) {
    this._held = held;
    this._mayPress = mayPress;
    this._mode = mode;
    this._commands = commands;
    /** What is deflected now, by source: what it does, or null if it must come back to rest first. @type {Map<string, string | null>} */
    this._active = new Map();
    /** Asking the browser costs a thread of it that polls. */
    this._isConnected = false;
    window.addEventListener("gamepadconnected", (event) => {
      this._isConnected = true;
      this._show(event.gamepad?.id ?? "");
    });
    window.addEventListener("gamepaddisconnected", () => {
      letGo("a gamepad is gone");
      this._isConnected = navigator.getGamepads().some((pad) => pad !== null);
      this._active.clear();
      this._show("");
    });
  }

  /** After this everything that is deflected has to come back to rest before it counts again. */
  block() {
    for (const source of this._active.keys()) this._active.set(source, null);
  }

  /** Read the gamepads; call it every COMMAND_PERIOD. */
  poll() {
    if (!this._isConnected) return;
    const { axes, buttons } = PAD[this._mode()];
    for (const pad of navigator.getGamepads()) {
      if (pad === null || pad.mapping !== "standard") continue;
      axes.forEach((ends, index) => {
        if (ends === null) return;
        const value = pad.axes[index] ?? 0;
        const amount = Math.max(0, (Math.abs(value) - DEAD_ZONE) / (1 - DEAD_ZONE));
        this._read(`pad:${pad.index}:-${index}`, ends[0], value < 0 ? amount : 0);
        this._read(`pad:${pad.index}:+${index}`, ends[1], value > 0 ? amount : 0);
      });
      for (const [button, index] of Object.entries(BUTTON)) {
        const name = ALWAYS[/** @type {keyof typeof ALWAYS} */ (button)] ?? buttons[/** @type {keyof typeof BUTTON} */ (button)];
        const value = pad.buttons[index]?.value ?? 0;
        if (name !== undefined) this._read(`pad:${pad.index}:${button}`, name, value > PRESSED ? value : 0);
      }
    }
  }

  /**
   * @param {string} source
   * @param {string} name
   * @param {number} amount  0 to 1
   */
  _read(source, name, amount) {
    if (amount === 0) {
      if (this._active.delete(source)) this._held.release(source);
    } else if (!this._active.has(source)) {
      const command = this._commands[/** @type {Command} */ (name)];
      const isHeld = command === undefined && this._mayPress();
      this._active.set(source, isHeld ? name : null);
      if (isHeld) this._held.press(source, name, amount);
      command?.();
    } else if (this._active.get(source) === name) {
      this._held.press(source, name, amount);
    }
  }

  /** @param {string} id */
  _show(id) {
    setText(byId("gamepad"), id === "" ? "" : `gamepad: ${id.replace(/\s*\(.*/, "").slice(0, 28)}`);
  }
}
