// @ts-check
/** A gamepad of the browser's standard layout, or a joystick that is like one: sticks and buttons that hold actions. */

import { text } from "./language.js";
import { demand } from "./pad_map.js";
import { byId, setText } from "./panels.js";

/** @typedef {import("./vocabulary.js").Mode} Mode */
/** @typedef {import("./pad_map.js").PadMap} PadMap */

const PRESSED = 0.5; // share of a button's way

/** Needs the enable button, though it moves nothing. */
const RELEASE = "release e-stop";

/** Is heeded by every console that is seen. */
const STOP = "e-stop";

/** Names of the controls in the order of the standard layout (W3C Gamepad, "remapping"). */
const AXES = ["left_stick_x", "left_stick_y", "right_stick_x", "right_stick_y"];
const BUTTONS = [
  "south", "east", "west", "north", "left_bumper", "right_bumper", "left_trigger", "right_trigger", "back", "start", "left_stick", "right_stick",
  "dpad_up", "dpad_down", "dpad_left", "dpad_right", "guide",
];

/** Whether it is known which of its controls is which. @param {Gamepad | null} pad */
const isUsable = (pad) => pad?.mapping === "standard";

/**
 * Values of a pad's controls, by their names.
 * @param {Gamepad} pad
 */
function valuesOf(pad) {
  const axes = AXES.map((name, index) => /** @type {[string, number]} */ ([name, pad.axes[index] ?? 0]));
  const buttons = BUTTONS.map((name, index) => /** @type {[string, number]} */ ([name, pad.buttons[index]?.value ?? 0]));
  return new Map([...axes, ...buttons]);
}

export class GamepadInput {
  /**
   * @param {object} page
   * @param {import("./held.js").Held} page.held
   * @param {() => boolean} page.mayPress
   * @param {() => Mode} page.mode
   * @param {(action: any) => string} page.nameOf  Name of the console's action that a pad's action is; empty if it has none.
   * @param {(name: string) => (() => void) | undefined} page.commandOf  What an action does at once; undefined: it is held.
   * @param {(reason: string) => void} page.letGo
   * @param {(sentence: string) => void} page.warn
   */
  constructor(page) {
    this._page = page;
    /** What controls do; null: not known yet, and nothing moves. @type {PadMap | null} */
    this.map = null;
    /** What is off its rest now, by source: what it does, or null if it must come back to rest first. @type {Map<string, string | null>} */
    this._active = new Map();
    /** Asking the browser costs a thread of it that polls. */
    this._isConnected = false;
    window.addEventListener("gamepadconnected", () => {
      this._isConnected = true;
      this._show();
    });
    window.addEventListener("gamepaddisconnected", () => {
      page.letGo(text("the gamepad was disconnected"));
      this._isConnected = navigator.getGamepads().some((pad) => pad !== null);
      this._show();
    });
  }

  /** After this everything that is off its rest has to come back to it before it counts again. */
  block() {
    for (const source of this._active.keys()) this._active.set(source, null);
  }

  /** Read the gamepads; call it every COMMAND_PERIOD. */
  poll() {
    if (!this._isConnected || this.map === null) return;
    // Browsers tell every window that is seen: of several robots' consoles, the pad moves the one that has the keyboard.
    const hasFocus = document.hasFocus();
    for (const pad of navigator.getGamepads()) {
      if (pad !== null && isUsable(pad)) this._readPad(pad, this.map, hasFocus);
    }
  }

  /**
   * @param {Gamepad} pad
   * @param {PadMap} map
   * @param {boolean} hasFocus
   */
  _readPad(pad, map, hasFocus) {
    const mode = map.modes.find(({ name }) => name === this._page.mode());
    if (mode === undefined) return;
    const values = valuesOf(pad);
    const isEnabled = (values.get(map.enable) ?? 0) > PRESSED;
    const layer = (values.get(map.shift) ?? 0) > PRESSED ? mode.shifted : mode.plain;
    for (const [control, value] of values) {
      if (control === map.enable || control === map.shift) continue;
      const source = `pad:${pad.index}:${control}`;
      const binding = layer[control];
      const { action, amount } = binding === undefined ? { action: null, amount: 0 } : demand(binding, value);
      const name = amount > 0 ? this._page.nameOf(action) : "";
      if (hasFocus || name === "" || action?.name === STOP) this._read(source, name, amount, isEnabled, action?.name === RELEASE);
      else {
        if (isEnabled && !this._active.has(source)) this._page.warn(text("the gamepad moves nothing here until you click into this window"));
        this._ignore(source);
      }
    }
  }

  /** Let go of what is off its rest, which has to come back to it before it counts. @param {string} source */
  _ignore(source) {
    this._active.set(source, null);
    this._page.held.release(source);
  }

  /**
   * @param {string} source
   * @param {string} name  What it does; empty: it is at rest, or does nothing.
   * @param {number} amount  0 to 1
   * @param {boolean} isEnabled
   * @param {boolean} needsEnable  Though it is done at once.
   */
  _read(source, name, amount, isEnabled, needsEnable) {
    const { held } = this._page;
    if (name === "") {
      if (this._active.delete(source)) held.release(source);
      return;
    }
    const command = this._page.commandOf(name);
    if (command !== undefined) {
      // Once per press that goes far enough, also for a trigger.
      if (amount <= PRESSED || this._active.has(source)) return;
      this._active.set(source, null);
      if (isEnabled || !needsEnable) command();
    } else if (!this._active.has(source)) {
      const isHeld = isEnabled && this._page.mayPress();
      this._active.set(source, isHeld ? name : null);
      if (isHeld) held.press(source, name, amount);
    } else if (this._active.get(source) === name && isEnabled) {
      held.press(source, name, amount);
    } else if (this._active.get(source) !== null) {
      // Enable was released, or the control has another meaning now.
      this._ignore(source);
    }
  }

  _show() {
    const pads = navigator.getGamepads().filter((pad) => pad !== null);
    const pad = pads.find(isUsable) ?? pads[0];
    const name = pad?.id.replace(/\s*\(.*/, "").slice(0, 28) ?? "";
    setText(byId("gamepad"), pad === undefined ? "" : isUsable(pad) ? text("gamepad: {name}", { name }) : text("gamepad: {name}, not usable", { name }));
  }
}
