// @ts-check
/** The gas sensor's read-out. */

import "./browser.js";
import assert from "node:assert/strict";
import { test } from "node:test";
import { GasView } from "../../console/js/gas.js";

test("the reading is shown while the sensor speaks, and goes with it", () => {
  /** @type {Record<string, any>} */
  const page = { values: { dataset: {} }, gas: { textContent: "" } };
  globalThis.document = /** @type {any} */ ({ getElementById: (/** @type {string} */ id) => page[id] ?? null });
  const view = new GasView();
  view.fade(false);
  assert.equal(page.values.dataset.gas, undefined);
  view.set({ concentration: 412 });
  assert.equal(page.gas.textContent, "412 ppm");
  view.fade(false);
  assert.equal(page.values.dataset.gas, "measured");
  view.set({ concentration: null });
  assert.equal(page.gas.textContent, "– ppm");
  view.forget();
  assert.equal(page.values.dataset.gas, undefined);
});
