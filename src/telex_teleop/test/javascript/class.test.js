// @ts-check
/** The page of a class: what its cards say, and its dialog that opens an exercise. */

import assert from "node:assert/strict";
import { test } from "node:test";

import { FakeElement } from "./browser.js";
import { lastText } from "../../../telex_training/pages/class/cards.js";

/** What stations tell of their trials. @type {any[]} */
let states = [];
/** What the stations are called, where not by their places. @type {string[] | null} */
let names = null;
/** What the page has sent. @type {any[]} */
const sent = [];
/** Have the page ask its server again. */
let lookAgain = () => {};
/** @type {Record<string, any>} */
const elements = {};
const settle = () => new Promise((resolve) => setImmediate(resolve));

/** @param {string} path */
function answerTo(path) {
  if (path.startsWith("api/open")) return { busy: {} };
  if (path.startsWith("api/texts")) return { de: { "Mop the cellar": "Den Keller wischen", "wring the mop": "den Lappen auswringen", "bucket upset": "Eimer umgestoßen" } };
  if (!path.startsWith("api/state")) return [];
  return { stations: states.map((state, index) => ({ name: names?.[index] ?? `s${index}`, phase: "here", since: 0, age: 0, reason: "", state, last: null, picture: null, picture_age: null, order: null })) };
}

async function look() {
  lookAgain();
  await settle();
}

/** The page, of which the server's answers are this test's. */
async function load() {
  const location = { search: "?lang=en", href: "http://class/", origin: "http://class" };
  Object.assign(globalThis, {
    location,
    history: { state: null, replaceState() {} },
    NodeFilter: { SHOW_TEXT: 4 },
    Option: FakeElement,
    document: {
      title: "", hidden: false, documentElement: {},
      getElementById: (/** @type {string} */ id) => (elements[id] ??= new FakeElement()),
      createElement: (/** @type {string} */ tag) => new FakeElement(tag),
      createTreeWalker: () => ({ nextNode: () => null }),
      querySelectorAll: () => [],
    },
    fetch: async (/** @type {string} */ path, /** @type {RequestInit} */ { body }) => {
      if (body !== undefined) sent.push(JSON.parse(String(body)));
      return { ok: true, json: async () => answerTo(path) };
    },
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
  await look();
  assert.deepEqual(shown(), [[true, "ann"], [false, "bob"], [true, "eve"]]);
  elements["order-close"].fire("click");
  states = [{ ...RUNNING, operator: "dan" }, { ...RUNNING, holder: "" }, { ...RUNNING, operator: "ida" }];
  await look();
  elements["order-open"].fire("click");
  assert.deepEqual(shown(), [[false, "dan"], [false, ""], [false, "ida"]]);
  assert.equal(elements["order-all"].checked, false);
});

test("what the class does not have any more since its server was started again leaves cards and rows, and is sent no order", async () => {
  states = [{ ...RUNNING, operator: "ann" }, { ...RUNNING, operator: "bob" }];
  names = ["station 1", "station 2"];
  await look();
  const cards = () => elements.stations.children.map((/** @type {any} */ card) => card.children[0].children[0].textContent);
  const rows = () => elements["order-rows"].children.map((/** @type {any} */ row) => row.children[1].textContent);
  assert.deepEqual(cards(), names);
  elements["order-open"].fire("click");
  assert.deepEqual(rows(), names);
  names = ["left", "station 2"];
  await look();
  assert.deepEqual(cards(), ["station 2", "left"]);
  assert.deepEqual(rows(), ["station 2"]);
  elements["order-close"].fire("click");
  states = [states[1]];
  names = ["right"];
  await look();
  elements["order-open"].fire("click");
  assert.deepEqual(rows(), ["right"]);
  elements["order-all"].checked = true;
  elements["order-all"].fire("change");
  elements["order-form"].fire("submit");
  await settle();
  assert.deepEqual(sent.map(({ stations }) => stations), [{ right: "bob" }]);
});

test("what exercises say in other languages by their own files is said on the cards", async () => {
  states = [{ ...RUNNING, title: "Mop the cellar", steps: ["wring the mop"], steps_done: [false], faults: ["bucket upset"] }];
  names = ["cellar"];
  await look();
  const facts = () => elements.stations.children[0].children[4].children.map((/** @type {any} */ part) => part.textContent);
  const about = (/** @type {string[]} */ words) => words.every((each) => facts().some((/** @type {string} */ fact) => fact.includes(each)));
  assert.ok(about(["Mop the cellar", "wring the mop", "bucket upset"]), facts().join(" | "));
  elements.language.fire("click");
  await settle();
  await look();
  assert.equal(elements.language.textContent, "DE");
  assert.ok(about(["Den Keller wischen", "den Lappen auswringen", "Eimer umgestoßen"]), facts().join(" | "));
});
