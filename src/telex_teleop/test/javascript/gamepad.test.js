// @ts-check
/** Gamepads: which of them count, and when. */

import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";

import "./browser.js";
import { GamepadInput } from "../../console/js/gamepad.js";
import { Held } from "../../console/js/held.js";

const [ENABLE, STOP] = [4, 10]; // numbers of buttons
const FORWARD = { kind: "drive", linear: 1, angular: 0 };
const PLAIN = { left_stick_y: { deadzone: 0.1, positive: { ...FORWARD, linear: -1 }, negative: FORWARD }, left_stick: { deadzone: 0.1, action: { kind: "command", name: "e-stop" } } };
const MAP = { enable: "left_bumper", shift: "right_bumper", modes: [{ name: "DRIVE", arm_mode: "", plain: PLAIN, shifted: {} }] };

/** @type {any} */
let pad;
/** @type {any[]} */
let pads;
let hasFocus = true;
let stops = 0;
/** @type {string[]} */
let warnings = [];
/** @type {Held} */
let held;
/** @type {GamepadInput} */
let input;
/** @type {Record<string, (event: any) => void>} */
const listeners = {};
const shown = { textContent: "" };

const made = (/** @type {object} */ values) => ({ index: 0, id: "Pad (of someone)", mapping: "standard", axes: [0, 0, 0, 0], buttons: Array.from({ length: 17 }, () => ({ value: 0 })), ...values });

beforeEach(() => {
  pad = made({});
  pads = [null, pad];
  [hasFocus, stops, warnings] = [true, 0, []];
  Object.assign(globalThis, {
    window: { addEventListener: (/** @type {string} */ kind, /** @type {() => void} */ hear) => { listeners[kind] = hear; } },
    document: { hasFocus: () => hasFocus, getElementById: () => shown },
  });
  Object.defineProperty(globalThis, "navigator", { value: { getGamepads: () => pads }, configurable: true });
  held = new Held(() => {});
  input = new GamepadInput({
    held, mayPress: () => true, mode: () => /** @type {any} */ ("DRIVE"), letGo: () => {}, warn: (sentence) => warnings.push(sentence),
    nameOf: (action) => action.name ?? (action.linear > 0 ? "ahead" : "back"),
    commandOf: (name) => (name === "e-stop" ? () => { stops += 1; } : undefined),
  });
  input.map = /** @type {any} */ (MAP);
  listeners.gamepadconnected({ gamepad: pad });
});

/** @param {number} way  Of the stick, with the enable button pressed. */
function push(way) {
  pad.buttons[ENABLE].value = 1;
  pad.axes[1] = -way;
  input.poll();
}

test("a pad moves the robot of the window that has the keyboard alone", () => {
  push(1);
  assert.deepEqual([...held.actions], ["ahead"]);
  hasFocus = false;
  push(1);
  assert.ok(held.empty);
  assert.deepEqual(warnings, []);
  for (const way of [0, 1, 1]) push(way);
  assert.ok(held.empty);
  assert.deepEqual(warnings, ["the gamepad moves nothing here until you click into this window"]);
});

test("what is held when the window gets the keyboard counts once it has been let go", () => {
  hasFocus = false;
  push(1);
  hasFocus = true;
  push(1);
  assert.ok(held.empty);
  push(0);
  push(1);
  assert.deepEqual([...held.actions], ["ahead"]);
});

test("a pad's e-stop counts in every window that is seen, once", () => {
  hasFocus = false;
  pad.buttons[STOP].value = 1;
  input.poll();
  assert.equal(stops, 1);
  hasFocus = true;
  input.poll();
  assert.equal(stops, 1);
});

test("of a pad whose layout is not known it is said that it does nothing", () => {
  assert.equal(shown.textContent, "gamepad: Pad");
  pads = [null, made({ mapping: "", id: "Old stick (Vendor: 046d)" })];
  listeners.gamepadconnected({ gamepad: pads[1] });
  assert.equal(shown.textContent, "gamepad: Old stick, not usable");
  // Beside one that can be used, that one is shown.
  pads = [...pads, pad];
  listeners.gamepadconnected({ gamepad: pad });
  assert.equal(shown.textContent, "gamepad: Pad");
  pads = [null, null, null];
  listeners.gamepaddisconnected({});
  assert.equal(shown.textContent, "");
});
