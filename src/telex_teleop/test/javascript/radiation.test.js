import assert from "node:assert/strict";
import { test } from "node:test";

import { clock } from "./browser.js";
import { DosimeterView } from "../../console/js/radiation/dosimeter.js";
import { RadiationTrack, bearingOf } from "../../console/js/radiation/track.js";
import { doseText, rateText } from "../../console/js/radiation/units.js";

/** What the page has, by ids. @type {Record<string, any>} */
const page = {};

function makePage() {
  for (const id of ["values", "dose-rate", "dose-total"]) page[id] = { textContent: "", dataset: {} };
  globalThis.document = /** @type {any} */ ({ getElementById: (/** @type {string} */ id) => page[id] ?? null });
}

const reading = (/** @type {object} */ more) => ({ hull_rate: 0.0123, tool_rate: 11.02, detector: "", total: 0.5, alarm: false, ...more });

test("figures have three digits and the prefix that suits them", () => {
  assert.deepEqual([1080, 999.6, 126.7, 11.02, 1, 0.9996, 0.0123, 0.000999, 1.2e-7, 1e-10, 0].map(rateText), [
    "1.08 kGy/h", "1.00 kGy/h", "127 Gy/h", "11.0 Gy/h", "1.00 Gy/h", "1.00 Gy/h", "12.3 mGy/h", "999 µGy/h", "0.12 µGy/h",
    "0 µGy/h", "0 µGy/h",
  ]);
  assert.equal(doseText(null), "–");
});

test("the read-out shows both rates, and of a robot without a tool the hull's", () => {
  makePage();
  const view = new DosimeterView(() => {});
  view.set(reading({}));
  assert.equal(page["dose-rate"].textContent, "hull 12.3 mGy/h  tool 11.0 Gy/h");
  assert.equal(page["dose-total"].textContent, "500 mGy");
  view.set(reading({ tool_rate: null }));
  assert.equal(page["dose-rate"].textContent, "hull 12.3 mGy/h");
});

test("an alarm is told once, when it begins", () => {
  makePage();
  /** @type {string[]} */
  const told = [];
  const view = new DosimeterView((sentence) => told.push(sentence));
  for (const alarm of [false, true, true, false, true]) view.set(reading({ alarm }));
  assert.equal(told.length, 2);
  assert.match(told[0], /^dose alarm: hull 12.3 mGy\/h {2}tool 11.0 Gy\/h, total 500 mGy$/);
  assert.match(page["dose-total"].textContent, /DOSE ALARM/);
  assert.equal(page.values.dataset.dose, "alarm");
});

test("it is there while the dosimeter speaks, and through a pause", () => {
  makePage();
  const view = new DosimeterView(() => {});
  clock.now = 10_000;
  view.set(reading({}));
  clock.now = 20_000;
  view.fade(true);
  assert.equal(page.values.dataset.dose, "measured");
  view.fade(false);
  assert.equal(page.values.dataset.dose, undefined);
});

/** A source of 1 Gy m2/h, and what is measured on a way to beside it. */
function passing() {
  const track = new RadiationTrack();
  for (let x = 0; x <= 4; x += 0.05) {
    track.move({ x, y: 0, yaw: 0 });
    track.measure(1 / ((x - 3) ** 2 + 1), null, null);
  }
  return track;
}

test("the track keeps a point each 10 cm, and knows where it was hottest", () => {
  const track = passing();
  assert.ok(track.points.length > 20 && track.points.length <= 41, String(track.points.length));
  assert.ok(Math.abs((track.hottest?.x ?? 0) - 3) < 0.11);
  assert.ok(Math.abs((track.range?.most ?? 0) - 1) < 0.02);
  track.move({ x: 0, y: 0, yaw: 0 });
  assert.equal(track.points.length, 0, "the odometry has begun anew");
});

test("turning the detector shows the source's bearing once it has seen both sides", () => {
  const track = new RadiationTrack();
  const source = 2.9; // rad; across it the angle wraps
  const seen = (/** @type {number} */ bearing) => 0.05 + 0.95 * 2 ** -((Math.atan2(Math.sin(bearing - source), Math.cos(bearing - source)) / 0.35) ** 2);
  for (let yaw = 2; yaw < 2.95; yaw += 0.02) {
    track.move({ x: 1, y: 1, yaw });
    track.measure(0.1, seen(yaw + 0.1), 0.1);
  }
  assert.equal(bearingOf(track.rose), null);
  for (let yaw = 2.95; yaw < 3.8; yaw += 0.02) {
    track.move({ x: 1, y: 1, yaw });
    track.measure(0.1, seen(yaw + 0.1), 0.1);
  }
  assert.ok(Math.abs((bearingOf(track.rose) ?? 0) - source) < 0.05);
  track.move({ x: 1.4, y: 1, yaw: 0 });
  assert.deepEqual(track.rose, [], "of another place it says nothing");
});

test("what is no figure is not drawn", () => {
  const track = new RadiationTrack();
  track.measure(1, null, null);
  track.move({ x: 0, y: 0, yaw: 0 });
  track.measure(NaN, null, null);
  assert.equal(track.points.length, 0);
  assert.equal(track.range, null);
});
