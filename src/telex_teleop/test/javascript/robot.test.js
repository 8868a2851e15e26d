// @ts-check
/** What the page is told of a robot, and what it leaves out. */

import "./browser.js";
import assert from "node:assert/strict";
import { test } from "node:test";
import { facts, made } from "./actions.js";
import { Gripper } from "../../console/js/gripper.js";
import { JointPositions } from "../../console/js/joints.js";
import { subjectsOf, viewActions } from "../../console/js/presence.js";
import { RobotWatch, UNKNOWN, isSameRobot, whichRobot } from "../../console/js/robot.js";

test("parts of the page are about kinds of actions, nodes, commands, and looking about", () => {
  const subjects = subjectsOf(made().all);
  for (const subject of ["drive", "arm", "flipper", "side", "tool", "pose", "lamps", "e-stop", "look"]) assert.ok(subjects.has(subject), subject);
  assert.ok(!subjects.has("gripper"));
  assert.ok(!subjectsOf(made().find("drive")).has("look"));
});

test("views are changed where there are cameras enough", () => {
  const command = (/** @type {string} */ name, /** @type {string} */ does) => /** @type {any} */ ({ name, does: { kind: "command", name: does } });
  const actions = [command("view", "next camera"), command("swap", "swap views"), command("small", "small views"), command("estop", "e-stop")];
  const shown = (/** @type {number} */ cameras) => [...viewActions(actions, cameras)].flatMap(([name, isThere]) => (isThere ? [name] : []));
  assert.deepEqual(shown(1), []);
  assert.deepEqual(shown(2), ["view", "swap"]);
  assert.deepEqual(shown(6), ["view", "swap", "small"]);
});

test("a gripper is where the mean of its joints is", () => {
  const joints = new JointPositions(facts.gripper);
  joints.set({ name: ["near_joint", "far_joint"], position: [0.02, 0.04], effort: [] });
  assert.equal(Math.round(1000 * /** @type {number} */ (joints.position("hand"))), 30);
  // One of another make than the parallel one with three joints a finger.
  assert.equal(new Gripper(facts.gripper).opening(joints), null);
  assert.equal(new Gripper(null).name, "");
  new JointPositions(null).set({ name: ["near_joint"], position: [0.02], effort: [] });
});

test("a robot is another one when something else of it moves, not when a camera zooms further", () => {
  assert.ok(isSameRobot(facts, { ...facts, cameras: { eye: { zoom_max: 4 } }, equipment: { pads: {} }, training_aids: {} }));
  assert.ok(!isSameRobot(facts, { ...facts, gripper: null }));
  assert.ok(!isSameRobot(UNKNOWN, facts));
});

test("the server is asked for this page's robot, without its token", () => {
  assert.equal(String(whichRobot(new URLSearchParams("robot=b&token=x&role=instructor"))), "robot=b");
});

test("how a robot is equipped is asked until it is told, and once after the simulator's first status", async (context) => {
  /** @type {any[]} */
  const answers = [];
  let asked = 0;
  context.mock.method(globalThis, "fetch", async () => {
    asked += 1;
    const answer = answers.length > 1 ? answers.shift() : answers[0];
    if (answer === null) throw new TypeError("no connection");
    return { ok: true, json: async () => answer };
  });
  /** @type {any[]} */
  const told = [];
  const watch = new RobotWatch(new URLSearchParams(), ({ equipment }) => told.push(equipment));
  await watch.hearStatus(); // before there is a connection
  assert.equal(asked, 0);
  answers.push({ equipment: {}, training_aids: {} }, { equipment: {}, training_aids: {} }, null, { equipment: { pads: {} }, training_aids: {} });
  await watch.connected();
  for (let second = 0; second < 5; second += 1) await watch.hearStatus();
  assert.deepEqual([asked, told], [4, [{}, {}, { pads: {} }]]);
  // What stands before the first status may be of the simulator before.
  await watch.connected();
  await watch.hearStatus();
  await watch.hearStatus();
  assert.equal(asked, 6);
  // Nothing is ever told of one that has nothing.
  answers.splice(0, 1, { equipment: {}, training_aids: {} });
  await watch.connected();
  for (let second = 0; second < 100; second += 1) await watch.hearStatus();
  assert.equal(asked, 6 + 1 + 30);
});
