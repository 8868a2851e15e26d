import assert from "node:assert/strict";
import { test } from "node:test";

import { FakeStorage } from "./browser.js";
import { made as makeVocabulary } from "./actions.js";
import { KeyMap } from "../../console/js/keymap.js";

const VOCABULARY = makeVocabulary();
const kept = (/** @type {any} */ storage) => new KeyMap(storage, VOCABULARY);
const made = (/** @type {Record<string, string>} */ values = {}) => kept(new FakeStorage(values));
const modesOf = (/** @type {string} */ name) => VOCABULARY.get(name)?.modes ?? [];
const NAMES = made().names;
const ODD = ["not JSON", "[]", "null", "3", '{"forward": 5, "no_such_action": "KeyX", "toString": "KeyY"}'];

test("every key finds what it belongs to, in every mode of that", () => {
  const keys = made();
  for (const name of NAMES) for (const mode of modesOf(name)) assert.equal(keys.find(keys.codeOf(name), mode), name);
  assert.equal(keys.find("NumpadAdd", "DRIVE"), "faster");
});

test("what has no key in the page gets none", () => {
  assert.ok(!NAMES.includes("release"));
  assert.equal(made({ "telex.keys": '{"release": "KeyX"}' }).find("KeyX", "DRIVE"), undefined);
});

test("two things change their keys, and the browser keeps that", () => {
  const storage = new FakeStorage();
  const keys = kept(storage);
  const [one, other] = ["faster", "drive:forward"];
  const [first, second] = [keys.codeOf(one), keys.codeOf(other)];
  let changes = 0;
  keys.changed = () => {
    changes += 1;
  };
  assert.deepEqual(keys.set(one, second), { swapped: [other] });
  assert.equal(keys.codeOf(other), first);
  assert.equal(changes, 1);
  const later = kept(storage);
  assert.equal(later.codeOf(one), second);
  assert.equal(later.codeOf(other), first);
  later.reset();
  assert.equal(kept(storage).codeOf(one), first);
});

test("a key of another mode stays what it was there", () => {
  const keys = made();
  assert.deepEqual(keys.set("tool_y:left", "KeyJ"), { swapped: [] });
  assert.deepEqual(keys.set("camera_pan:left", "KeyZ"), { swapped: [] });
  assert.equal(keys.codeOf("pose:stow"), "KeyZ");
  assert.equal(keys.codeOf("turret:left"), "KeyJ");
});

test("nothing gets the old key where that has another meaning", () => {
  const storage = new FakeStorage();
  const keys = kept(storage);
  const refused = { swapped: [], obstacle: { other: "drive:forward", has: "turret:left" } };
  assert.deepEqual(keys.set("camera_pan:left", "KeyW"), refused);
  assert.deepEqual(keys.set("tool_y:left", "KeyZ"), { swapped: [], obstacle: { other: "pose:stow", has: "turret:left" } });
  for (const each of [keys, kept(storage)]) {
    for (const name of NAMES) for (const mode of modesOf(name)) assert.equal(each.find(each.codeOf(name), mode), name);
  }
  // Once that has another key, it goes.
  keys.set("turret:left", "KeyP");
  keys.set("tool_y:left", "KeyP");
  assert.deepEqual(keys.set("camera_pan:left", "KeyW"), { swapped: ["drive:forward"] });
  assert.equal(keys.find("KeyJ", "JOINT"), "drive:forward");
});

test("a further key is what the user makes of it", () => {
  const keys = made();
  keys.set("drive:forward", "NumpadAdd");
  assert.equal(keys.find("NumpadAdd", "DRIVE"), "drive:forward");
  assert.equal(keys.find("Equal", "DRIVE"), "faster");
  keys.reset();
  assert.equal(keys.find("NumpadAdd", "DRIVE"), "faster");
  keys.set("turret:left", "NumpadAdd");
  assert.equal(keys.find("NumpadAdd", "JOINT"), "turret:left");
  assert.equal(keys.find("NumpadAdd", "DRIVE"), undefined);
});

for (const stored of ODD) {
  test(`what another program has stored is no key map: ${stored}`, () => {
    const keys = made({ "telex.keys": stored });
    for (const name of NAMES) assert.equal(keys.codeOf(name), made().codeOf(name));
  });
}

test("a key is called as most keyboards print it", () => {
  assert.equal(made().capOf("KeyB"), "B");
  assert.equal(made().capOf("F13"), "F13");
});
