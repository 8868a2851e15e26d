// @ts-check
/** When a view counts as live. */

import "./browser.js";
import assert from "node:assert/strict";
import { test } from "node:test";
import { ViewState } from "../../console/js/cameras.js";
import { Line } from "../../console/js/line.js";

Object.defineProperty(Date, "now", { value: () => 1e12 });

/** A line of which this was heard. @param {number} delay  s @param {number} [jitter]  s */
function lineOf(delay, jitter = 0) {
  const line = new Line(() => {});
  const perfect = delay === 0;
  line.hear({ profile: "fields", perfect, delay, jitter, loss: 0, bandwidth: 0, outage: false, signal_known: false, signal: 0 });
  return line;
}

/**
 * Whether a view is live.
 * @param {Line} line
 * @param {number} age  Of the scene (ms).
 * @param {number} [since]  Since its picture was drawn (ms).
 */
function isLive(line, age, since = 0) {
  const view = new ViewState(line);
  view.camera = "front";
  const now = Date.now();
  view.set({ camera: "front", drawn: now - since, captured: now - age, latency: age - since, width: 640, rate: 10, trouble: "" });
  return view.live;
}

test("a view whose scene is older than a second is not live", () => {
  for (const line of [new Line(() => {}), lineOf(0)])
    assert.deepEqual([isLive(line, 900), isLive(line, 1100), isLive(line, 1100, 1100)], [true, false, false]);
});

test("a line makes scenes older, and pictures no rarer", () => {
  const slow = lineOf(1);
  assert.deepEqual([isLive(slow, 1040), isLive(slow, 2100)], [true, false]);
  const slowest = lineOf(9, 1);
  assert.deepEqual([isLive(slowest, 10_500), isLive(slowest, 11_100), isLive(slowest, 10_500, 1100)], [true, false, false]);
});
