// @ts-check
/** What the header says of the battery. */

import "./browser.js";
import assert from "node:assert/strict";
import { test } from "node:test";
import { BatteryView, chargeText, runtime } from "../../console/js/battery.js";

test("the runtime is that of the present current", () => {
  assert.equal(runtime(10, 5), 120);
  assert.equal(runtime(10, 0), null);
  assert.equal(runtime(10, null), null);
  assert.equal(runtime(NaN, 5), null);
});

test("charge and runtime are never said to be more than they are", () => {
  assert.equal(chargeText(1, 400.9), "100 % · 6 h 40 min");
  assert.equal(chargeText(0.129, 12.9), "12 % · 12 min");
  assert.equal(chargeText(0.5, null), "50 %");
  assert.equal(chargeText(0, null), "EMPTY");
  assert.equal(chargeText(0.129, 12.9, 389.9), "12 % · 12 min · 380 m");
  assert.equal(chargeText(0.5, null, 0.4), "50 % · 0 m");
  assert.equal(chargeText(1, 400.9, 6480), "100 % · 6 h 40 min · 6.4 km");
  assert.equal(chargeText(1, null, 99.9), "100 % · 99 m");
  assert.equal(chargeText(0, 0, 0), "EMPTY");
});

test("what is not measured is neither low nor a current of zero", () => {
  /** @type {Record<string, any>} */
  const page = { battery: { dataset: {} }, "battery-text": {} };
  Object.assign(globalThis, { document: { getElementById: (/** @type {string} */ id) => page[id] } });
  const battery = new BatteryView();
  battery.set({ percentage: null, charge: null, current: null });
  assert.ok(page.battery.hidden);
  assert.equal(battery.isLow, false);
  battery.set({ percentage: 0.5, charge: 10, current: -5 });
  battery.set({ percentage: 0.5, charge: 10, current: null });
  assert.equal(page["battery-text"].textContent, "50 % · 2 h 0 min");
  assert.ok(!page.battery.hidden && !battery.isLow);
  battery.set({ percentage: 0.1, charge: 2, current: -5 });
  assert.ok(battery.isLow);
  battery.set({ percentage: null, charge: null, current: null });
  assert.equal(battery.isLow, false);
});
