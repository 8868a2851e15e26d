import assert from "node:assert/strict";
import { test } from "node:test";

import { FakeStorage } from "./browser.js";
import { KeyMap, MODES, capOf, modesOf } from "../../console/js/keymap.js";
import { ACTIONS, COMMANDS } from "../../console/js/robot.js";

const made = (/** @type {Record<string, string>} */ values = {}) => new KeyMap(/** @type {any} */ (new FakeStorage(values)));
const NAMES = [...Object.keys(ACTIONS), ...Object.keys(COMMANDS)];
const ODD = ["not JSON", "[]", "null", "3", '{"forward": 5, "no_such_action": "KeyX", "toString": "KeyY"}'];

test("in no mode two things have the same key", () => {
  const keys = made();
  for (const mode of MODES) {
    const codes = NAMES.filter((name) => modesOf(name).includes(mode)).map((name) => keys.codeOf(name)).filter(Boolean);
    assert.equal(new Set(codes).size, codes.length, `${mode}: ${codes}`);
  }
});

test("every key finds what it belongs to, in every mode of that", () => {
  const keys = made();
  for (const name of NAMES) for (const mode of modesOf(name)) if (keys.codeOf(name)) assert.equal(keys.find(keys.codeOf(name), mode), name);
});

test("two things change their keys, and the browser keeps that", () => {
  const storage = new FakeStorage();
  const keys = new KeyMap(/** @type {any} */ (storage));
  const [one, other] = Object.keys(COMMANDS);
  const [first, second] = [keys.codeOf(one), keys.codeOf(other)];
  let changes = 0;
  keys.changed = () => {
    changes += 1;
  };
  assert.deepEqual(keys.set(one, second), [other]);
  assert.equal(keys.codeOf(other), first);
  assert.equal(changes, 1);
  const later = new KeyMap(/** @type {any} */ (storage));
  assert.equal(later.codeOf(one), second);
  assert.equal(later.codeOf(other), first);
  later.reset();
  assert.equal(new KeyMap(/** @type {any} */ (storage)).codeOf(one), first);
});

test("a key of another mode stays what it was there", () => {
  const keys = made();
  const tool = NAMES.find((name) => modesOf(name).join() === "CARTESIAN" && keys.codeOf(name));
  const camera = NAMES.find((name) => modesOf(name).join() === "CAMERA" && keys.codeOf(name));
  assert.ok(tool && camera);
  const before = keys.codeOf(camera);
  assert.deepEqual(keys.set(tool, before).filter((name) => modesOf(name).includes("CAMERA")), []);
  assert.equal(keys.codeOf(camera), before);
});

for (const stored of ODD) {
  test(`what another program has stored is no key map: ${stored}`, () => {
    const keys = made({ "telex.keys": stored });
    for (const name of NAMES) assert.equal(keys.codeOf(name), made().codeOf(name));
  });
}

test("a browser that stores nothing has the keys until the page is closed", () => {
  const refusing = { getItem: () => null, setItem: () => { throw new Error("QuotaExceededError"); } };
  const keys = new KeyMap(/** @type {any} */ (refusing));
  keys.set("estop", "F13");
  assert.equal(keys.codeOf("estop"), "F13");
});

test("a key is called as most keyboards print it", () => {
  assert.equal(capOf("KeyQ").length > 0, true);
  assert.equal(capOf("F13"), "F13");
});
