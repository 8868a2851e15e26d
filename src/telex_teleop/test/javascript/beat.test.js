// @ts-check
/** What changes the page comes together, and nothing of it is lost. */

import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";

import "./browser.js";
import { atBeat } from "../../console/js/beat.js";
import { Bridge } from "../../console/js/bridge.js";

/** What waits for its time: no browser's timers run here. @type {(() => void)[]} */
let timers;
/** @type {any[]} */
let errors;
const beat = () => timers.splice(0).forEach((timer) => timer());

const document = { hidden: false };
globalThis.document = /** @type {any} */ (document);
globalThis.reportError = (error) => errors.push(error);
globalThis.setTimeout = /** @type {any} */ ((/** @type {() => void} */ timer) => timers.push(timer));
globalThis.clearTimeout = /** @type {any} */ (() => {});

beforeEach(() => {
  timers = [];
  errors = [];
  document.hidden = false;
});

test("what is asked for several times comes once, with all that it asks for", () => {
  /** @type {string[]} */
  const called = [];
  const paint = () => called.push("paint");
  const news = () => {
    called.push("news");
    atBeat(paint);
  };
  atBeat(news);
  atBeat(news);
  assert.equal(timers.length, 1);
  assert.deepEqual(called, []);
  beat();
  assert.deepEqual(called, ["news", "paint"]);
  beat();
  assert.deepEqual(called, ["news", "paint"]);
});

test("what asks for itself comes at the next beat", () => {
  let count = 0;
  const again = () => {
    count += 1;
    if (count < 3) atBeat(again);
  };
  atBeat(again);
  for (const wanted of [1, 2, 3, 3]) {
    beat();
    assert.equal(count, wanted);
  }
});

test("what fails is reported, and keeps nothing else from coming", () => {
  /** @type {string[]} */
  const called = [];
  atBeat(() => {
    throw new Error("lost");
  });
  atBeat(() => called.push("after"));
  beat();
  assert.deepEqual(called, ["after"]);
  assert.equal(errors[0].message, "lost");
});

function hearingBridge() {
  const bridge = new Bridge(async () => "", { opened() {}, lost() {}, refused() {} });
  /** @type {string[]} */
  const heard = [];
  for (const topic of ["a", "b"]) bridge.subscribe({ topic, type: "std_msgs/String", throttle: 0, heard: ({ data }) => heard.push(topic + data) });
  const hear = (/** @type {string} */ topic, /** @type {number} */ data) => /** @type {any} */ (bridge)._receive({ op: "publish", topic, msg: { data } });
  return { bridge, heard, hear };
}

test("messages come at the beat, all of them, in their order", () => {
  const { bridge, heard, hear } = hearingBridge();
  hear("a", 1);
  hear("b", 1);
  hear("a", 2);
  assert.deepEqual(heard, []);
  bridge.unsubscribe("b");
  beat();
  assert.deepEqual(heard, ["a1", "a2"]);
});

test("a page that nobody sees hears at once what it had not heard before", () => {
  const { heard, hear } = hearingBridge();
  hear("a", 1);
  document.hidden = true;
  hear("b", 1);
  assert.deepEqual(heard, ["a1", "b1"]);
  beat();
  assert.deepEqual(heard, ["a1", "b1"]);
});

test("nothing of a connection is heard after its end", () => {
  const { bridge, heard, hear } = hearingBridge();
  hear("a", 1);
  /** @type {any} */ (bridge)._giveUp("the connection was closed");
  beat();
  assert.deepEqual(heard, []);
});
