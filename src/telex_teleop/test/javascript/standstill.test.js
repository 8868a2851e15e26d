// @ts-check
/** A page that is stopped in the middle of a command, and woken, moves nothing. */

import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";

import { clock, paced } from "./browser.js";
import { Bridge } from "../../console/js/bridge.js";
import { keepPace } from "../../console/js/deadman.js";

const PERIOD = 50; // ms
const STOPPED = 400; // ms

/** What the bridge was told. @type {any[]} */
let told;
/** @type {Bridge} */
let bridge;
/** @type {string[]} */
let reasons;
/** What happens in a tick. @type {() => void} */
let act;

globalThis.WebSocket = /** @type {any} */ ({ OPEN: 1 });

const publish = (/** @type {string} */ topic) => bridge.publish(topic, {});
const tick = () => {
  clock.now += PERIOD;
  paced[paced.length - 1]();
};

beforeEach(() => {
  told = [];
  reasons = [];
  act = () => {};
  bridge = new Bridge(async () => "", { opened() {}, lost() {}, refused() {} });
  Object.assign(bridge, { _socket: { readyState: 1, send: (/** @type {string} */ text) => told.push(JSON.parse(text)) } });
  bridge.advertise("cmd_vel", "geometry_msgs/Twist", { held: true });
  bridge.advertise("lamp", "std_msgs/Float64");
  told = [];
  keepPace(PERIOD, () => act(), (reason) => reasons.push(reason));
});

test("what is held is not published by a tick in which the page stood still, and let go of in the next", () => {
  act = () => {
    clock.now += STOPPED;
    assert.equal(publish("cmd_vel"), false);
    assert.equal(publish("lamp"), true);
  };
  tick();
  assert.deepEqual(told.map(({ topic }) => topic), ["lamp"]);
  assert.deepEqual(reasons, []);
  act = () => assert.equal(publish("cmd_vel"), true); // the stop
  tick();
  assert.equal(reasons.length, 1);
  assert.equal(told[1].topic, "cmd_vel");
});

test("letting go of it publishes its stop at once", () => {
  paced.length = 0;
  keepPace(PERIOD, () => {}, () => publish("cmd_vel"));
  clock.now += STOPPED;
  tick();
  assert.equal(told.length, 1);
});

test("a message is as old as the look at the clock that found it fresh", () => {
  act = () => {
    const { now } = performance;
    // Stopped right after the clock was read, and by the next reading awake again.
    performance.now = () => {
      const read = now();
      clock.now += STOPPED;
      return read;
    };
    try {
      publish("cmd_vel");
    } finally {
      performance.now = now;
    }
  };
  tick();
  assert.equal(told.length, 1);
  assert.ok(clock.now - told[0].sent >= STOPPED);
});
