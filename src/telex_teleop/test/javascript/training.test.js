// @ts-check
/** What the strip of an exercise says. */

import { paced } from "./browser.js";
import assert from "node:assert/strict";
import { test } from "node:test";
import { nextLanguage } from "../../console/js/language.js";
import { bookmarksOf } from "../../console/js/training/instructor_bookmarks.js";
import { addressOf, clockText } from "../../console/js/training/client.js";
import { offered } from "../../console/js/training/bookmarks.js";
import { malfunctionsText, noteOf, repetitionText, sheetAddress, stepText } from "../../console/js/training/strip.js";
import { tellTelemetry } from "../../console/js/training/telemetry.js";

const STATE = /** @type {any} */ ({
  phase: "running", message: "", hint: "slower", mode: "practice", verdict: "", repetition: 2, repetitions: 10, results: ["passed"],
  valid: true, steps: ["out", "back"], steps_done: [true, false], from_bookmark: "", bookmarks: [], faults: [],
});

test("the step that is due is named with its number", () => {
  assert.equal(stepText(STATE), "2/2 back");
  assert.equal(stepText({ ...STATE, steps_done: [false, false] }), "1/2 out");
  assert.match(stepText({ ...STATE, phase: "waiting", steps_done: [false, false] }), /the clock starts.*first: out/);
  assert.equal(stepText({ ...STATE, phase: "between" }), "repetition ended");
});

test("repetitions are counted, with their limit where there is one", () => {
  assert.equal(repetitionText(STATE), "rep 2/10");
  assert.equal(repetitionText({ ...STATE, repetitions: 0 }), "rep 2");
  assert.equal(repetitionText({ ...STATE, repetition: 0 }), "");
});

test("hints are for practice, and what went wrong comes first", () => {
  assert.equal(noteOf(STATE), "slower");
  assert.equal(noteOf({ ...STATE, mode: "exam" }), "");
  assert.equal(noteOf({ ...STATE, message: "the disk is full" }), "the disk is full");
  assert.equal(noteOf({ ...STATE, phase: "between", results: ["passed", "tipped"] }), "fault: tipped");
  assert.equal(noteOf({ ...STATE, phase: "ended", verdict: "passed" }), "PASSED: see the sheet");
  assert.equal(noteOf({ ...STATE, phase: "ended" }), "no verdict: see the sheet");
  assert.equal(noteOf({ ...STATE, phase: "ended", verdict: "passed", valid: false }), "not valid: see the sheet");
});

test("what has failed is said in the language that is shown", () => {
  assert.equal(malfunctionsText({ ...STATE, malfunctions: [] }), "");
  const failing = { ...STATE, malfunctions: ["x", "y"] };
  assert.equal(malfunctionsText(failing), "Malfunction: x · y");
  nextLanguage();
  assert.equal(malfunctionsText(failing), "Störung: x · y");
  nextLanguage();
  assert.equal(malfunctionsText(failing), "Panne\u00a0: x · y");
  nextLanguage();
});

test("what goes on from a bookmark is told to be practice only", () => {
  const resumed = { ...STATE, from_bookmark: "out, repetition 2" };
  assert.equal(repetitionText(resumed), "practice only, from: out, repetition 2");
  assert.equal(noteOf({ ...resumed, phase: "between", steps_done: [true, true], faults: ["cone"] }), "done, as practice only");
  assert.equal(noteOf({ ...resumed, phase: "between", faults: ["cone", "tipped"] }), "fault: tipped; practice only");
});

test("bookmarks are offered in practice, while there is something to go back in", () => {
  const having = { ...STATE, bookmarks: ["out, repetition 1", "mark 1, repetition 2"] };
  assert.deepEqual(offered(having), { canSet: true, names: having.bookmarks });
  assert.deepEqual(offered({ ...having, phase: "between" }), { canSet: false, names: having.bookmarks });
  for (const phase of ["ready", "preparing", "ended"]) assert.deepEqual(offered({ ...having, phase }), { canSet: false, names: [] });
  assert.deepEqual(offered({ ...having, mode: "exam" }), { canSet: false, names: [] });
});

test("an instructor's bookmarks are the trial's while one goes on", () => {
  assert.equal(bookmarksOf(null), "simulator");
  assert.equal(bookmarksOf(STATE), "practice");
  assert.equal(bookmarksOf({ ...STATE, mode: "exam" }), "exam");
  for (const phase of ["idle", "ready", "ended"]) assert.equal(bookmarksOf({ ...STATE, phase, mode: "exam" }), "simulator");
});

test("times are minutes and seconds", () => {
  assert.equal(clockText(0), "00:00");
  assert.equal(clockText(125.9), "02:05");
});

test("an address takes token and role along, and nothing else", () => {
  const given = new URLSearchParams("token=a%26b&role=instructor&name=eve&debug=1");
  assert.equal(addressOf("/training/x", given, { trial: "t 1" }), "/training/x?trial=t+1&token=a%26b&role=instructor");
  assert.equal(addressOf("/training/x", new URLSearchParams()), "/training/x");
});

test("a sheet is read under the operator's name, and by an instructor under his own", () => {
  const state = { ...STATE, trial: "t1", operator: "Ann" };
  assert.equal(sheetAddress(state, new URLSearchParams("token=T&name=Bob")), "/training/sheet.html?trial=t1&name=Ann&token=T");
  const eve = new URLSearchParams("token=T&role=instructor&name=Eve");
  assert.equal(sheetAddress(state, eve), "/training/sheet.html?trial=t1&name=Eve&token=T&role=instructor");
});

test("what the operator sees is told, with the aids that are on where the page has any", () => {
  Object.assign(globalThis, { document: { hidden: false } });
  const told = /** @type {any[]} */ ([]);
  const bridge = /** @type {any} */ ({
    connected: true, usualTrip: 50, advertise: () => {}, publish: (/** @type {string} */ name, /** @type {any} */ { data }) => told.push([name, JSON.parse(data)]),
  });
  /** @type {any} */
  let seen = { view: "front", picture_age: 0.1 };
  tellTelemetry(bridge, (name) => `/telex/${name}`, () => seen);
  const tick = paced[paced.length - 1];
  tick();
  seen = { view: "gripper", picture_age: null, aids: { horizon: false, proximity: true } };
  tick();
  seen = null;
  tick();
  const name = "/telex/console/telemetry";
  assert.deepEqual(told, [
    [name, { view: "front", picture_age: 0.1, round_trip: 0.05 }],
    [name, { view: "gripper", round_trip: 0.05, aids: { horizon: false, proximity: true } }],
  ]);
});
