// @ts-check
/** Line, malfunctions and trials as the instructor's panels understand them. */

import "./browser.js";
import assert from "node:assert/strict";
import { test } from "node:test";
import { lineText } from "../../console/js/instructor/line_panel.js";
import { AtNextStep } from "../../console/js/instructor/malfunction_panel.js";

// The panel's questions listen to the keys.
Object.assign(globalThis, { window: { addEventListener() {} } });
const { stateText } = await import("../../console/js/training/instructor_panel.js");

const PERFECT = { profile: "perfect", delay: 0, jitter: 0, loss: 0, bandwidth: 0, outage: false };
const RUNNING = { trial: "t1", phase: "running", repetition: 1, steps_done: [false, false] };
const FROZEN = { what: "front", kind: "frozen", value: 0, announced: false };

test("a line says what it does to what passes it", () => {
  assert.equal(lineText(PERFECT), "nothing is impaired");
  assert.equal(lineText({ ...PERFECT, delay: 0.3 }), "300 ms");
  assert.equal(lineText({ ...PERFECT, delay: 0.1, jitter: 0.1, loss: 0.085, bandwidth: 4e6 }), "100–200 ms, 8.5 % lost, 4 Mbit/s");
  assert.equal(lineText({ ...PERFECT, delay: 0.3, outage: true }), "nothing passes now");
});

test("what waits for the next step is due with it, once", () => {
  const waiting = new AtNextStep();
  assert.deepEqual(waiting.hear(RUNNING), []);
  waiting.add(FROZEN);
  assert.deepEqual(waiting.hear(RUNNING), []);
  assert.deepEqual(waiting.hear({ ...RUNNING, steps_done: [true, false] }), [FROZEN]);
  assert.deepEqual(waiting.hear({ ...RUNNING, steps_done: [true, true] }), []);
});

test("a step that was done before is no next one, and a new repetition is none", () => {
  const waiting = new AtNextStep();
  waiting.hear({ ...RUNNING, steps_done: [true, false] });
  waiting.add(FROZEN);
  assert.deepEqual(waiting.hear({ ...RUNNING, steps_done: [true, false] }), []);
  assert.deepEqual(waiting.hear({ ...RUNNING, repetition: 2 }), []);
  assert.deepEqual(waiting.hear({ ...RUNNING, repetition: 2, steps_done: [true, false] }), [FROZEN]);
});

test("what waits is forgotten with the trial, or when it is cancelled", () => {
  for (const over of [{ ...RUNNING, phase: "ended" }, { ...RUNNING, trial: "t2" }]) {
    const waiting = new AtNextStep();
    waiting.hear(RUNNING);
    waiting.add(FROZEN);
    assert.deepEqual(waiting.hear({ ...over, steps_done: [true, false] }), []);
    assert.deepEqual(waiting.wishes, []);
  }
  const waiting = new AtNextStep();
  waiting.hear(RUNNING);
  waiting.add(FROZEN);
  waiting.remove(FROZEN);
  assert.deepEqual(waiting.hear({ ...RUNNING, steps_done: [true, false] }), []);
});

test("a trial that is not valid is said to be that once it has ended, whatever its figures are", () => {
  const state = /** @type {any} */ ({ operator: "ann", title: "Slalom", setting: "standard", mode: "practice", phase: "ended", verdict: "passed", valid: true });
  assert.equal(stateText(state), "ann · Slalom · practice · passed");
  assert.equal(stateText({ ...state, verdict: "" }), "ann · Slalom · practice · no verdict");
  assert.equal(stateText({ ...state, valid: false }), "ann · Slalom · practice · not valid");
  assert.equal(stateText({ ...state, valid: false, phase: "running" }), "ann · Slalom · practice · running");
  assert.equal(stateText(null), "none is open");
});
