// @ts-check
/** The page of a class: what its cards say, and its dialog that opens an exercise. */

import assert from "node:assert/strict";
import { test } from "node:test";

import { FakeElement } from "./browser.js";
import { lastText } from "../../../telex_training/pages/class/cards.js";

/** What stations tell of their trials. @type {any[]} */
let states = [];
/** Have the page ask its server again. */
let lookAgain = () => {};
/** @type {Record<string, any>} */
const elements = {};
const settle = () => new Promise((resolve) => setImmediate(resolve));

/** The page, of which the server's answers are this test's. */
async function load() {
  const location = { search: "?lang=en", href: "http://class/", origin: "http://class" };
  Object.assign(globalThis, {
    location,
    NodeFilter: { SHOW_TEXT: 4 },
    Option: FakeElement,
    document: {
      title: "", hidden: false, documentElement: {},
      getElementById: (/** @type {string} */ id) => (elements[id] ??= new FakeElement()),
      createElement: (/** @type {string} */ tag) => new FakeElement(tag),
      createTreeWalker: () => ({ nextNode: () => null }),
      querySelectorAll: () => [],
    },
    fetch: async (/** @type {string} */ path) => ({
      ok: true,
      json: async () => (path.startsWith("api/state") ? { stations: states.map((state, index) => ({ name: `s${index}`, phase: "here", since: 0, age: 0, reason: "", state, last: null, picture: null, picture_age: null, order: null })) } : []),
    }),
    setTimeout: (/** @type {() => void} */ again) => { lookAgain = again; },
  });
  await import("../../../telex_training/pages/class/class.js");
}

const RUNNING = {
  phase: "running", title: "Slalom", setting: "day", mode: "practice", operator: "", holder: "", valid: true, repetition: 1, repetitions: 5, results: [],
  elapsed: 1, penalty: 0, steps: [], steps_done: [], faults: [], message: "", verdict: "", help: null,
};

test("a trial that is not valid is said to be that, whatever its figures are", () => {
  const ended = { title: "Slalom", setting: "standard", operator: "ann", valid: true, verdict: "passed" };
  assert.equal(lastText(ended), "last: passed · Slalom · ann");
  assert.equal(lastText({ ...ended, verdict: "" }), "last: no verdict · Slalom · ann");
  assert.equal(lastText({ ...ended, valid: false }), "last: not valid · Slalom · ann");
  assert.equal(lastText({ ...ended, valid: false, verdict: "" }), "last: not valid · Slalom · ann");
  assert.equal(lastText(null), "");
});

test("whoever opens the dialog finds nobody chosen, and the names of those who sit there now", async () => {
  states = [{ ...RUNNING, operator: "ann" }, { ...RUNNING, holder: "bob" }, null];
  await load();
  await settle();
  elements["order-open"].fire("click");
  const rows = elements["order-rows"].children.map((/** @type {any} */ { children: [chosen, , trainee] }) => ({ chosen: chosen.children[0], trainee: trainee.children[0] }));
  const shown = () => rows.map((/** @type {any} */ { chosen, trainee }) => [chosen.checked, trainee.value]);
  assert.deepEqual(shown(), [[false, "ann"], [false, "bob"], [false, ""]]);
  rows[2].trainee.value = "eve";
  rows[2].trainee.fire("input");
  rows[0].chosen.checked = elements["order-all"].checked = true;
  lookAgain();
  await settle();
  assert.deepEqual(shown(), [[true, "ann"], [false, "bob"], [true, "eve"]]);
  elements["order-close"].fire("click");
  states = [{ ...RUNNING, operator: "dan" }, { ...RUNNING, holder: "" }, { ...RUNNING, operator: "ida" }];
  lookAgain();
  await settle();
  elements["order-open"].fire("click");
  assert.deepEqual(shown(), [[false, "dan"], [false, ""], [false, "ida"]]);
  assert.equal(elements["order-all"].checked, false);
});
