// @ts-check
/** The robot's lamps as the page shows them. */

import assert from "node:assert/strict";
import { test } from "node:test";

import "./browser.js";
import { made } from "./actions.js";
import { Lamps } from "../../console/js/lamps.js";

const NAMES = ["front_left", "front_right"];

function lampsOf(/** @type {boolean} */ isConnected) {
  /** @type {Record<string, any>} */
  const heard = {}, sent = /** @type {[string, number][]} */ ([]);
  const button = () => ({ dataset: {}, shows: "", setAttribute(/** @type {string} */ name, /** @type {string} */ value) { if (name === "aria-checked") this.shows = value; } });
  Object.assign(globalThis, { document: { createElement: button } });
  const bridge = {
    advertise() {},
    subscribe: (/** @type {any} */ { topic, heard: hear }) => { heard[topic] = hear; },
    publish: (/** @type {string} */ topic, /** @type {any} */ { data }) => isConnected && sent.push([topic, data]) > 0,
  };
  const lamps = new Lamps(made(), /** @type {any} */ (bridge), (name) => name, /** @type {any} */ ({ append() {} }), "command");
  lamps.advertise();
  const tell = (/** @type {number} */ data) => { for (const lamp of NAMES) heard[`lamps/${lamp}/level`]({ data }); };
  return { lamps, sent, tell, shown: () => /** @type {any} */ (lamps.switches[0].button).shows };
}

test("a lamp is lit when the robot says so, not when it was asked to", () => {
  const { lamps, sent, tell, shown } = lampsOf(true);
  tell(0);
  assert.ok(lamps.toggle(NAMES));
  assert.deepEqual(sent, NAMES.map((lamp) => [`lamps/${lamp}/command`, 1]));
  assert.equal(shown(), "false");
  tell(1);
  assert.equal(shown(), "true");
  assert.ok(lamps.toggle(NAMES));
  assert.deepEqual(sent.slice(2), NAMES.map((lamp) => [`lamps/${lamp}/command`, 0]));
  assert.equal(shown(), "true");
});

test("what was not sent is told", () => {
  const { lamps, shown } = lampsOf(false);
  assert.ok(!lamps.toggle(NAMES));
  assert.equal(shown(), "false");
});
