import assert from "node:assert/strict";
import { test } from "node:test";

import "./browser.js";
import { Line } from "../../console/js/line.js";

const state = (/** @type {Partial<import("../../console/js/line.js").LinkState>} */ changes = {}) => ({
  profile: "300", perfect: false, delay: 0.3, jitter: 0, loss: 0, bandwidth: 0, outage: false, signal_known: false, signal: 0, ...changes,
});

test("of a perfect line nothing is said", () => {
  const line = new Line(() => {});
  assert.deepEqual([line.impaired, line.text, line.quality, line.signal], [false, "", null, null]);
  line.hear(state({ profile: "perfect", perfect: true, delay: 0 }));
  assert.deepEqual([line.impaired, line.text], [false, ""]);
  assert.match(line.silent(1500), /does not answer/);
});

test("delay, jitter and an outage are said", () => {
  /** @type {string[]} */
  const logged = [];
  const line = new Line((sentence) => logged.push(sentence));
  line.hear(state());
  assert.equal(line.text, "300 ms each way");
  line.hear(state({ jitter: 0.1 }));
  assert.equal(line.text, "300–400 ms each way");
  line.hear(state({ outage: true }));
  assert.equal(line.text, "DOWN");
  line.hear(state());
  assert.deepEqual(logged, ["line: 300", "the line is down", "the line is up again"]);
  assert.match(line.silent(1500), /line is down: nothing has come from the robot for 1.5 s/);
});

test("the signal tells the quality", () => {
  const line = new Line(() => {});
  const qualities = [0.9, 0.4, 0.1].map((signal) => {
    line.hear(state({ profile: "by_distance", signal_known: true, signal }));
    return line.quality;
  });
  assert.deepEqual(qualities, ["good", "fair", "poor"]);
  assert.equal(line.text, "300 ms each way, signal 10 %");
  line.hear(state({ signal_known: true, signal: 0.01, outage: true }));
  assert.deepEqual([line.quality, line.text], ["lost", "DOWN, signal 1 %"]);
});
