import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";

import { clock } from "./browser.js";
import { facts, made } from "./actions.js";
import { Commander } from "../../console/js/commander.js";
import { FLIPPER_NODE, JOINT_NODES, TRACK_NODE } from "../../console/js/robot.js";

class FakeBridge {
  waiting = 0;
  connected = true;
  /** @type {Array<{topic: string, message: any}>} */
  sent = [];

  advertise() {}

  /** @param {string} topic @param {any} message */
  publish(topic, message) {
    if (this.connected) this.sent.push({ topic, message });
    return this.connected;
  }

  take() {
    return this.sent.splice(0);
  }
}

const DRIVE = { kind: "drive", linear: 1, angular: 0 };
const TURN = { kind: "drive", linear: 0, angular: -1 };
const JOINT = { kind: "jog", node: "arm", joints: ["elbow_joint"], sign: 1 };
const speed = { speed_scale: 0.5, min_speed_scale: 0.05, max_speed_scale: 1.0 };

/** @type {FakeBridge} */
let bridge;
/** @type {string[]} */
let warnings;
/** @type {Commander} */
let commander;
const update = (/** @type {any[]} */ ...held) => {
  commander.update(held);
  return bridge.take();
};

beforeEach(() => {
  bridge = new FakeBridge();
  warnings = [];
  commander = new Commander(made(), /** @type {any} */ (bridge), (name) => `/telex/${name}`, (sentence) => warnings.push(sentence), facts);
  commander.setTrackStatus({ max_linear: 0.6, max_angular: 1.2, ...speed });
  commander.setJointStatus(JOINT_NODES[0], { joint_names: ["elbow_joint", "still_joint"], max_velocity: [0.4, 0], ...speed });
});

test("nothing held, nothing sent", () => {
  assert.deepEqual(update(), []);
});

test("the tracks are told the robot's own speed, and a zero at the end, once", () => {
  const [{ topic, message }] = update(DRIVE, TURN);
  assert.equal(topic, `/telex/${TRACK_NODE}/cmd_vel`);
  assert.deepEqual(message, { linear: { x: 0.6 }, angular: { z: -1.2 } });
  assert.ok(commander.busy);
  assert.deepEqual(update()[0].message, { linear: { x: 0 }, angular: { z: 0 } });
  assert.ok(!commander.busy);
  assert.deepEqual(update(), []);
});

test("a stick drives by its way", () => {
  assert.equal(update({ ...DRIVE, amount: 0.25 })[0].message.linear.x, 0.15);
});

test("two that hold the same action drive no faster", () => {
  assert.equal(update(DRIVE, { ...DRIVE, amount: 0.5 })[0].message.linear.x, 0.6);
});

test("both keys of a pair are no motion", () => {
  assert.deepEqual(update(DRIVE, { ...DRIVE, linear: -1 }), []);
  assert.deepEqual(update(JOINT, { ...JOINT, sign: -1 }), []);
});

test("a joint gets its velocity, and a zero when it is let go", () => {
  const [{ topic, message }] = update(JOINT);
  assert.equal(topic, `/telex/${JOINT_NODES[0]}/delta_joint_cmds`);
  assert.deepEqual([message.joint_names, message.velocities], [["elbow_joint"], [0.4]]);
  assert.deepEqual(update()[0].message.velocities, [0]);
  assert.deepEqual(update(), []);
});

test("the zero of a joint is said three times while another one moves on", () => {
  commander.setJointStatus(JOINT_NODES[0], { joint_names: ["elbow_joint", "wrist_joint"], max_velocity: [0.4, 0.4], ...speed });
  const other = { ...JOINT, joints: ["wrist_joint"] };
  update(JOINT, other);
  for (let said = 0; said < 3; said += 1) {
    assert.deepEqual(update(other)[0].message.joint_names, ["wrist_joint", "elbow_joint"]);
  }
  assert.deepEqual(update(other)[0].message.joint_names, ["wrist_joint"]);
});

test("what has not said how fast it may move is not moved, and the operator is told", () => {
  assert.deepEqual(update({ ...JOINT, joints: ["still_joint"] }), []);
  assert.match(warnings[0], /still_joint/);
});

test("motion does not queue behind old motion, but a stop goes through", () => {
  update(DRIVE, JOINT);
  bridge.waiting = 5000;
  assert.deepEqual(update(DRIVE, JOINT), []);
  assert.equal(update().length, 2);
});

test("a stop that could not be sent is sent later", () => {
  update(DRIVE);
  bridge.connected = false;
  update();
  assert.ok(commander.busy);
  bridge.connected = true;
  assert.deepEqual(update()[0].message, { linear: { x: 0 }, angular: { z: 0 } });
});

test("without a connection nothing is moving any more: the bridge has stopped it", () => {
  update(DRIVE, JOINT);
  commander.disconnected();
  assert.ok(!commander.busy);
  assert.deepEqual(update(), []);
});

test("a preset is held and let go; two are none", () => {
  commander.presets = ["flat", "climb"];
  const preset = (/** @type {number} */ index) => ({ kind: "preset", index });
  const topic = `/telex/${FLIPPER_NODE}/preset_cmds`;
  assert.deepEqual(update(preset(1)), [{ topic, message: { header: {}, preset: "climb", joint_names: [] } }]);
  assert.equal(update(preset(0), preset(1))[0].message.preset, "");
  assert.deepEqual(update(preset(0), preset(1)), []);
  assert.deepEqual(update(preset(7)), []);
  assert.match(warnings[0], /no flipper preset 8/);
});

test("with a side held, a preset names the flippers of that side", () => {
  commander.presets = ["flat"];
  const [{ message }] = update({ kind: "preset", index: 0 }, { kind: "side", name: "left" });
  assert.deepEqual(message.joint_names, ["a_joint", "c_joint"]);
});

test("of a robot that has no flippers on a side, none follow: without names, all would", () => {
  const none = new Commander(made(), /** @type {any} */ (bridge), (name) => name, (sentence) => warnings.push(sentence), { ...facts, sides: { left: [], right: [] } });
  none.presets = ["flat"];
  none.update(/** @type {any[]} */ ([{ kind: "preset", index: 0 }, { kind: "side", name: "left" }]));
  assert.deepEqual(bridge.take(), []);
  assert.match(warnings[0], /no flippers are known on the left/);
});

test("a gripper that does not say how fast it closes does so as fast as its joints", () => {
  commander.setJointStatus(JOINT_NODES[1], { joint_names: ["near_joint", "far_joint"], max_velocity: [0.3, 0.2], ...speed });
  const [{ message }] = update({ kind: "jog", node: "gripper", joints: ["hand"], sign: -1 });
  assert.deepEqual([message.joint_names, message.velocities], [["hand"], [-0.2]]);
});

test("a side that is held wins over the chosen one, both sides are both", () => {
  const side = (/** @type {string} */ name) => /** @type {any} */ ({ kind: "side", name });
  commander.side = "left";
  assert.equal(commander.sideOf([]), "left");
  assert.equal(commander.sideOf([side("right")]), "right");
  assert.equal(commander.sideOf([side("right"), side("left")]), "both");
});

test("the speed goes to the next tenth, and no farther than it may", () => {
  commander.setTrackStatus({ max_linear: 0.6, max_angular: 1.2, ...speed, speed_scale: 0.05 });
  commander.setJointStatus(JOINT_NODES[0], { joint_names: [], max_velocity: [], ...speed, speed_scale: 0.05 });
  const scales = [];
  for (let step = 0; step < 11; step += 1) {
    commander.changeSpeed(1);
    scales.push(bridge.take()[0].message.data);
  }
  assert.deepEqual(scales.map((scale) => Math.round(1e3 * scale)), [100, 200, 300, 400, 500, 600, 700, 800, 900, 1000, 1000]);
  assert.deepEqual(commander.speeds, [1]);
  clock.now += 600; // the nodes have not taken it over
  assert.deepEqual(commander.speeds, [0.05]);
});
