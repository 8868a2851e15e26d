// @ts-check
/** Several robots: which names are the robot's that a page shows, and which the simulator's. */

import "./browser.js";
import assert from "node:assert/strict";
import { test } from "node:test";
import { globalNames, robotOf, showRobot } from "../../console/js/several_robots.js";

const ALONE = /** @type {import("../../console/js/config.js").Config} */ (/** @type {unknown} */ ({ namespace: "/telex" }));
const SECOND = /** @type {import("../../console/js/config.js").Config} */ ({
  ...ALONE, namespace: "/telex_b", simulator: "/telex",
  robots: [{ name: "telex", rosbridge: null }, { name: "telex_b", rosbridge: null }],
});

test("the simulator's own services are where the simulator is, all else is the robot's", () => {
  const name = globalNames(SECOND);
  assert.equal(name("sim/pause"), "/telex/sim/pause");
  assert.equal(name("sim/load_scene"), "/telex/sim/load_scene");
  for (const own of ["sim/status", "sim/malfunction", "sim/base_pose", "e_stop", "arm_teleop/hold_tool"]) {
    assert.equal(name(own), `/telex_b/${own}`);
  }
  assert.equal(globalNames(ALONE)("sim/pause"), "/telex/sim/pause");
});

test("a page says which robot it shows where there are several", () => {
  const brand = /** @type {HTMLElement} */ (/** @type {unknown} */ ({ textContent: "TELEX", dataset: {} }));
  globalThis.document = /** @type {Document} */ (/** @type {unknown} */ ({ title: "Telex console" }));
  showRobot(ALONE, brand);
  assert.equal(brand.textContent, "TELEX");
  showRobot({ ...ALONE, namespace: "/rover" }, brand);
  assert.equal(brand.textContent, "ROVER");
  document.title = "Telex console";
  showRobot(SECOND, brand);
  assert.equal(brand.textContent, "telex_b");
  assert.equal(robotOf(SECOND), "telex_b");
  assert.equal(document.title, "telex_b · Telex console");
});
