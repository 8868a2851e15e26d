// @ts-check
/** When a view counts as live. */

import "./browser.js";
import assert from "node:assert/strict";
import { test } from "node:test";
import { ViewState } from "../../console/js/cameras.js";
import { Line } from "../../console/js/line.js";

/**
 * Whether it is live.
 * @param {number} age  Of the scene (ms).
 * @param {number} [since]  Since its picture was drawn (ms).
 */
function isLive(age, since = 0) {
  const view = new ViewState();
  view.camera = "front";
  const now = Date.now();
  view.set({ camera: "front", drawn: now - since, captured: now - age, latency: age - since, width: 640, rate: 10, trouble: "" });
  return view.live;
}

/** Hear of a line. @param {number} delay  s @param {number} [jitter]  s */
function hear(delay, jitter = 0) {
  const perfect = delay === 0;
  new Line(() => {}).hear({ profile: "fields", perfect, delay, jitter, loss: 0, bandwidth: 0, outage: false, signal_known: false, signal: 0 });
}

test("a view whose scene is older than a second is not live", () => {
  hear(0);
  assert.deepEqual([isLive(900), isLive(1100), isLive(1100, 1100)], [true, false, false]);
});

test("a line makes scenes older, and pictures no rarer", () => {
  hear(1);
  assert.deepEqual([isLive(1040), isLive(2100)], [true, false]);
  hear(9, 1);
  assert.deepEqual([isLive(10_500), isLive(11_100), isLive(10_500, 1100)], [true, false, false]);
  hear(0);
  assert.deepEqual([isLive(900), isLive(1100)], [true, false]);
});
