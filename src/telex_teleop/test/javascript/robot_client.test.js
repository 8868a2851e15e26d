// @ts-check
/** Calls of services that tell why nothing was done. */

import "./browser.js";
import assert from "node:assert/strict";
import { test } from "node:test";
import { RobotClient } from "../../console/js/robot_client.js";

/** @param {() => any} answer */
async function asked(answer) {
  /** @type {string[]} */
  const warnings = [], called = /** @type {string[]} */ ([]);
  const bridge = { call: async (/** @type {string} */ service) => { called.push(service); return answer(); } };
  const robot = new RobotClient(/** @type {any} */ (bridge), (name) => `/telex/${name}`, () => {}, (sentence) => warnings.push(sentence));
  const given = await robot.request("sim/light", {}, (why) => `light: ${why}`);
  assert.deepEqual(called, ["/telex/sim/light"]);
  return { given, warnings };
}

test("an answer is handed on, also of a service that knows no refusal", async () => {
  for (const answer of [{ success: true, message: "done" }, { names: [] }]) {
    assert.deepEqual(await asked(() => answer), { given: answer, warnings: [] });
  }
});

test("a refusal is told in the words of the service", async () => {
  assert.deepEqual(await asked(() => ({ success: false, message: "no such lamp" })), { given: null, warnings: ["no such lamp"] });
});

test("a missing answer is told in the words of the caller", async () => {
  const failing = () => { throw new Error("not connected"); };
  assert.deepEqual(await asked(failing), { given: null, warnings: ["light: not connected"] });
});
