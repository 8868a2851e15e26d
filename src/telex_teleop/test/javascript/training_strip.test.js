// @ts-check
/** What the strip of an exercise lets trainee and instructor do. */

import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";

import { FakeElement } from "./browser.js";
import { TrainingStrip } from "../../console/js/training/strip.js";

/** What the page has, by ids. @type {Map<string, any>} */
const page = new Map();
/** @param {string} id @returns {any} */
const get = (id) => page.get(id) ?? page.set(id, new FakeElement()).get(id);

class NamedElement extends FakeElement {
  /** @param {string} id */
  set id(id) {
    page.set(id, this);
  }
}

Object.assign(globalThis, {
  Option: NamedElement,
  document: { createElement: (/** @type {string} */ tag) => new NamedElement(tag), getElementById: get },
});

const STATE = /** @type {any} */ ({
  trial: "t1", title: "Ring", setting: "standard", mode: "exam", operator: "ann", valid: true, invalid_because: [], repetition: 1,
  repetitions: 3, from_bookmark: "", bookmarks: [], results: [], elapsed: 0, penalty: 0, trial_elapsed: 0, trial_limit: 0,
  steps: ["look"], steps_done: [false], faults: [], malfunctions: [], hint: "", message: "", help: false, verdict: "",
  questions: [
    { name: "ring", ask: "Where is it open?", choices: ["up", "down"], answered: false },
    { name: "gauge", ask: "What does it show?", choices: [], answered: false },
  ],
});

/** @type {string[]} */
const asked = [];
/** What was said with the last one. @type {any} */
let said;

/** Show a phase. @param {string} phase  @param {boolean} isWatched  @param {string} [mode]  @param {boolean} [help]  Whether it is asked for. */
function show(phase, isWatched, mode = "exam", help = false) {
  if (isWatched) get("training").dataset.watched = "true";
  const client = /** @type {any} */ ({
    act(/** @type {string} */ name, /** @type {object} */ args) {
      asked.push(name);
      said = args;
    },
  });
  new TrainingStrip(client, new URLSearchParams(), () => {}).show({ ...STATE, phase, mode, help, bookmarks: ["start", "door"] });
}

/** Names of the buttons that are there. */
const shown = () => ["start", "again", "give-up", "help", "bookmarks", "sheet"].filter((name) => !get(`training-${name}`).hidden);

beforeEach(() => {
  page.clear();
  asked.length = 0;
});

test("a trainee can do again, give up and answer", () => {
  show("running", false);
  assert.deepEqual(shown(), ["again", "give-up", "help"]);
  const questions = get("training-questions").children;
  assert.deepEqual(questions.map(({ tags }) => tags), [["label", "button", "button"], ["label", "input"]]);
  questions[0].children[1].fire("click");
  assert.deepEqual(asked, ["answer"]);
});

test("a trainee goes back to the bookmark of his choice, in practice", () => {
  show("running", false);
  assert.ok(get("training-bookmarks").hidden);
  show("running", false, "practice");
  assert.deepEqual(shown(), ["again", "give-up", "help", "bookmarks"]);
  assert.equal(get("training-bookmarks-names").value, "door");
  get("training-bookmarks-names").value = "start";
  get("training-back").fire("click");
  assert.deepEqual([asked, said], [["back"], { name: "start" }]);
});

test("who watches reads the questions, and can do nothing that counts for the trainee", () => {
  for (const phase of ["preparing", "waiting", "running", "between"]) {
    for (const mode of ["exam", "practice"]) {
      show(phase, true, mode);
      assert.deepEqual(shown(), [], phase);
    }
  }
  // Who is called for help can say that he was there.
  show("running", true, "practice", true);
  assert.deepEqual(shown(), ["help"]);
  show("running", true);
  const questions = get("training-questions").children;
  assert.deepEqual(questions.map(({ tag, tags, textContent }) => [tag, tags, textContent]), [
    ["div", [], "Where is it open? up, down"], ["div", [], "What does it show? "],
  ]);
});

test("who watches can start a trial and open its sheet", () => {
  show("ready", true);
  assert.deepEqual(shown(), ["start"]);
  show("ended", true);
  assert.deepEqual(shown(), ["sheet"]);
});
