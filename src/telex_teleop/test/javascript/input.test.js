// @ts-check
/** Keys and buttons of a mouse whose release the page is not told. */

import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";

import "./browser.js";
import { GamepadInput } from "../../console/js/gamepad.js";
import { Held } from "../../console/js/held.js";
import { listenToKeys, listenToPointers, walkButtons } from "../../console/js/input.js";

class FakeElement {
  dataset = { action: "ahead" };

  /** @param {string} tag */
  constructor(tag) {
    this.tag = tag;
  }

  /** @param {string} selector */
  matches(selector) {
    return selector.split(", ").includes(this.tag);
  }

  closest() {
    return this.tag === "button" ? this : null;
  }

  setPointerCapture() {}
}

/** What the page listens to. @type {Map<string, ((event: any) => void)[]>} */
let listeners;
/** @type {Held} */
let held;
/** @type {string[]} */
let reasons;
const listen = (/** @type {string} */ kind, /** @type {(event: any) => void} */ hear) => {
  listeners.set(kind, [...(listeners.get(kind) ?? []), hear]);
};
const say = (/** @type {string} */ kind, /** @type {object} */ event) => {
  const usual = { target: new FakeElement("body"), timeStamp: performance.now(), button: 0, pointerId: 1, pointerType: "mouse", preventDefault() {} };
  for (const hear of listeners.get(kind) ?? []) hear({ ...usual, ...event });
};
const letGo = (/** @type {string} */ reason) => {
  reasons.push(reason);
  held.releaseAll();
};

beforeEach(() => {
  listeners = new Map();
  reasons = [];
  held = new Held(() => {});
  Object.assign(globalThis, { window: { addEventListener: listen }, Element: FakeElement, HTMLElement: FakeElement });
  globalThis.document = /** @type {any} */ ({ activeElement: null, getElementById: () => ({ textContent: "" }) });
  listenToKeys(held, () => true, (code) => ({ KeyW: "ahead" })[code], () => undefined, () => false, letGo);
  listenToPointers(/** @type {any} */ ({ addEventListener: listen }), held, () => true);
});

for (const kind of ["mousedown", "focusin"]) {
  test(`a list takes no key along that is held, by ${kind}`, () => {
    say("keydown", { code: "KeyW" });
    say(kind, { target: new FakeElement("button") });
    say(kind, { target: new FakeElement("input") });
    assert.deepEqual([...held.actions], ["ahead"]);
    say(kind, { target: new FakeElement("select") });
    assert.ok(held.empty);
    assert.deepEqual(reasons, ["a list was opened"]);
  });
}

test("the command key lets go, for others' release is not told while it is down", () => {
  say("keydown", { code: "KeyW" });
  say("keydown", { code: "MetaLeft", metaKey: true });
  assert.ok(held.empty);
  say("keydown", { code: "KeyW", metaKey: true });
  assert.ok(held.empty);
  say("keyup", { code: "MetaLeft" });
  say("keydown", { code: "KeyW", repeat: true });
  assert.ok(held.empty);
});

test("a mouse's left button is let go while another one is down", () => {
  const button = new FakeElement("button");
  say("pointerdown", { target: button, buttons: 1 });
  say("pointermove", { target: button, buttons: 3 });
  assert.deepEqual([...held.actions], ["ahead"]);
  say("pointermove", { target: button, buttons: 2 });
  assert.ok(held.empty);
});

test("a finger's movement is no release", () => {
  const button = new FakeElement("button");
  say("pointerdown", { target: button, buttons: 1, pointerType: "touch" });
  say("pointermove", { target: button, buttons: 0, pointerType: "touch" });
  assert.deepEqual([...held.actions], ["ahead"]);
});

test("walking begins at the first button that is seen", () => {
  class Button extends FakeElement {
    /** @param {boolean} isSeen */
    constructor(isSeen) {
      super("button");
      this.isSeen = isSeen;
    }

    getClientRects() {
      return this.isSeen ? [{}] : [];
    }

    focus() {
      if (this.isSeen) Object.assign(document, { activeElement: this });
    }

    blur() {
      Object.assign(document, { activeElement: null });
    }
  }
  const buttons = [false, true, true].map((isSeen) => new Button(isSeen));
  const brief = Object.assign(new FakeElement("div"), { hidden: false, querySelector: () => buttons[0], querySelectorAll: () => buttons });
  Object.assign(document, { body: null, querySelectorAll: () => [brief] });
  walkButtons();
  assert.equal(document.activeElement, buttons[1]);
  walkButtons();
  assert.equal(document.activeElement, null);
});

test("what another gamepad holds does not go on when one is pulled out", () => {
  /** @type {any[]} */
  const pads = [0, 1].map((index) => ({ index, id: `pad ${index}`, mapping: "standard", axes: [0, -1, 0, 0], buttons: [] }));
  Object.defineProperty(globalThis, "navigator", { value: { getGamepads: () => pads }, configurable: true });
  /** @type {GamepadInput} */
  const input = new GamepadInput({
    held, mayPress: () => true, mode: () => /** @type {any} */ ("DRIVE"), nameOf: () => "ahead", commandOf: () => undefined,
    letGo: (reason) => {
      input.block();
      letGo(reason);
    },
  });
  say("gamepadconnected", { gamepad: pads[1] });
  /** @type {any} */ (input)._read("pad:1:left_stick_y", "ahead", 1, true, false);
  assert.deepEqual([...held.actions], ["ahead"]);
  say("gamepaddisconnected", { gamepad: pads[0] });
  assert.ok(held.empty);
  /** @type {any} */ (input)._read("pad:1:left_stick_y", "ahead", 1, true, false);
  assert.ok(held.empty);
  /** @type {any} */ (input)._read("pad:1:left_stick_y", "", 0, true, false);
  /** @type {any} */ (input)._read("pad:1:left_stick_y", "ahead", 1, true, false);
  assert.deepEqual([...held.actions], ["ahead"]);
});
