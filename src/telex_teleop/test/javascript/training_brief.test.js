// @ts-check
/** What the brief of an exercise says of passing, times and keys. */

import "./browser.js";
import assert from "node:assert/strict";
import { test } from "node:test";
import { deedsOf, passOf, timesOf } from "../../console/js/training/brief.js";

const BRIEF = /** @type {any} */ ({
  repetitions: { most: 10, least: 2, time: 420, trial_time: 1800 }, begins: { english: "a command is given", values: {} }, best: 31.26,
  expert: { seconds: 23.3, spread: 0, provisional: true, sees: "all places" },
});

test("a pass value is said with its side and unit", () => {
  assert.equal(passOf(/** @type {any} */ ({ pass: 180, unit: "s", more_is_better: false })), "at most 180 s");
  assert.equal(passOf(/** @type {any} */ ({ pass: 0, unit: "", more_is_better: false })), "none");
  assert.equal(passOf(/** @type {any} */ ({ pass: 0, unit: "", more_is_better: true })), "at least 0");
  assert.equal(passOf(/** @type {any} */ ({ pass: -4, unit: "", more_is_better: true })), "at least -4");
});

test("limits, one's own best and the expert's time are said", () => {
  assert.deepEqual(timesOf(BRIEF), [
    ["clock starts", "when a command is given"],
    ["repetitions", "10 at most, 2 completed for a verdict"],
    ["each", "07:00 at most"],
    ["trial", "30:00 at most"],
    ["your best", "31.3 s"],
    ["expert", "23.3 s; provisional, by a script, which knows all places"],
  ]);
});

test("what has no limit, no best and no expert is not invented", () => {
  const free = { ...BRIEF, repetitions: { most: 0, least: 1, time: 0, trial_time: 0 }, best: null, expert: null };
  assert.deepEqual(timesOf(free).slice(1), [
    ["repetitions", "as many as you like, 1 completed for a verdict"],
    ["your best", "none in this setting yet"],
  ]);
});

test("keys that belong together say once what they are about", () => {
  const action = (/** @type {string} */ name, /** @type {string} */ label, /** @type {string} */ row) => /** @type {any} */ ({ name, label, row });
  assert.equal(deedsOf([action("tool_x:ahead", "ahead", "x ahead"), action("tool_x:back", "back", "x ahead")]), "x ahead, back");
  assert.equal(deedsOf([action("gripper:close", "close", "opening"), action("gripper:open", "open", "opening")]), "close, open");
});
