import assert from "node:assert/strict";
import { test } from "node:test";

import { clock } from "./browser.js";
import { DosimeterView } from "../../console/js/radiation/dosimeter.js";
import { doseText, rateText } from "../../console/js/radiation/units.js";

/** What the page has, by ids. @type {Record<string, any>} */
const page = {};

function makePage() {
  for (const id of ["values", "dose-rate", "dose-total"]) page[id] = { textContent: "", dataset: {} };
  globalThis.document = /** @type {any} */ ({ getElementById: (/** @type {string} */ id) => page[id] ?? null });
}

const reading = (/** @type {object} */ more) => ({ hull_rate: 0.0123, tool_rate: 11.02, total: 0.5, alarm: false, ...more });

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
