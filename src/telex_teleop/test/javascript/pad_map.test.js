import assert from "node:assert/strict";
import { test } from "node:test";

import "./browser.js";
import { made } from "./actions.js";
import { demand } from "../../console/js/pad_map.js";

const STICK = { deadzone: 0.1, positive: "right", negative: "left" };

test("a stick rests within its deadzone and begins at 0 beyond it", () => {
  assert.equal(demand(STICK, 0.1).amount, 0);
  assert.equal(demand(STICK, -0.05).amount, 0);
  assert.ok(demand(STICK, 0.11).amount < 0.02);
});

test("a stick's ends are two actions, each to its whole extent", () => {
  assert.deepEqual(demand(STICK, 1), { action: "right", amount: 1 });
  assert.deepEqual(demand(STICK, -1), { action: "left", amount: 1 });
});

test("a stick is finer near its middle by its cubic part, and slower by its scale", () => {
  const half = demand(STICK, 0.55).amount;
  assert.ok(Math.abs(half - 0.5) < 1e-9);
  assert.ok(Math.abs(demand({ ...STICK, expo: 1 }, 0.55).amount - 0.125) < 1e-9);
  assert.ok(Math.abs(demand({ ...STICK, scale: 0.5 }, 1).amount - 0.5) < 1e-9);
});

test("a button is no stick: what comes from below its rest is none", () => {
  assert.deepEqual(demand({ deadzone: 0.5, action: "stop" }, -1), { action: "stop", amount: 0 });
  assert.deepEqual(demand({ deadzone: 0.5, action: "stop" }, 1), { action: "stop", amount: 1 });
});

test("a pad's actions are those of the keys", () => {
  const vocabulary = made();
  for (const { name, does } of vocabulary.all) {
    if (name !== "camera_pan:left") assert.equal(vocabulary.nameOf({ ...does }, ["flat", "climb"]), name);
  }
  // The pad's file may name joints and lamps in another order, and a robot have other presets.
  assert.equal(vocabulary.nameOf({ kind: "lamps", names: ["front_right", "front_left"] }, []), "lamps:front");
  assert.equal(vocabulary.nameOf({ kind: "preset", name: "own" }, ["flat", "own"]), "preset:1");
});

for (const wanted of [
  { kind: "preset", name: "no such" },
  { kind: "command", name: "no such" },
  { kind: "pose", name: "no such" },
  { kind: "jog", node: "arm", joints: ["turret_joint"], sign: -1 },
  { kind: "of the future" },
]) {
  test(`what the console has no action for has no name: ${JSON.stringify(wanted)}`, () => {
    assert.equal(made().nameOf(wanted, ["flat"]), "");
  });
}
