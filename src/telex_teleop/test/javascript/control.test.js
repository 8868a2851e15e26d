import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";

import "./browser.js";
import { Bridge } from "../../console/js/bridge.js";
import { ControlView } from "../../console/js/control.js";

/** What the page has said to the bridge. @type {any[]} */
let said;
/** @type {Bridge} */
let bridge;
/** @type {ControlView} */
let control;
/** @type {string[]} */
let warnings;

class FakeSocket {
  static OPEN = 1;
  readyState = 1;
  bufferedAmount = 0;

  /** @param {string} text */
  send(text) {
    said.push(JSON.parse(text));
  }
}

const element = () => ({ dataset: {}, classList: { toggle() {} }, hidden: false, textContent: "", title: "" });
/** @type {Record<string, any>} */
const elements = {};
globalThis.WebSocket = /** @type {any} */ (FakeSocket);
globalThis.document = /** @type {any} */ ({
  getElementById: (/** @type {string} */ id) => (elements[id] ??= element()),
  body: element(),
});

/** @param {any} operation  Of the bridge, as this page gets it. */
const hear = (operation) => /** @type {any} */ (bridge)._receive(operation);
const beat = () => new Promise((resolve) => setTimeout(resolve, 80));

const answer = (/** @type {string} */ service, /** @type {object} */ values) => {
  const { id } = /** @type {any} */ ([...said].reverse().find((each) => each.service === service));
  hear({ op: "service_response", id, result: true, values });
};

beforeEach(async () => {
  said = [];
  warnings = [];
  bridge = new Bridge(async () => "", { opened() {}, lost() {}, refused() {} });
  /** @type {any} */ (bridge)._socket = new FakeSocket();
  bridge.advertise("drive", "geometry_msgs/Twist");
  bridge.advertise("e_stop", "std_msgs/Bool", { urgent: true });
  control = new ControlView(bridge, (name) => name, () => false, (sentence) => warnings.push(sentence));
  control.subscribe();
  const known = control.connected();
  answer("bridge/who_am_i", { success: true, message: "7" });
  await known;
  hear({ op: "publish", topic: "bridge/clients", msg: { holder: "7", clients: [{ id: "7", name: "" }] } });
  await beat();
  said = [];
});

test("nothing but the e-stop follows a release until it is answered", async () => {
  const released = control.toggle();
  assert.deepEqual(said.map(({ service }) => service), ["bridge/release_control"]);
  assert.ok(control.givesUp);
  assert.equal(bridge.publish("drive", {}), false);
  assert.equal(bridge.publish("e_stop", { data: true }), true);
  // A second click is not one that takes it.
  await control.toggle();
  assert.deepEqual(said.map(({ op }) => op), ["call_service", "publish"]);
  answer("bridge/release_control", { success: true, message: "control is free" });
  await released;
  assert.equal(control.givesUp, false);
  assert.equal(bridge.publish("drive", {}), true);
  assert.deepEqual(warnings, []);
});

test("a release that is refused or lost lets the page go on", async () => {
  const refused = control.toggle();
  answer("bridge/release_control", { success: false, message: "client 7 does not hold control" });
  await refused;
  assert.equal(bridge.publish("drive", {}), true);
  const lost = control.toggle();
  for (const end of [.../** @type {any} */ (bridge)._calls.values()]) end({ result: false, values: "the connection was lost" });
  await lost;
  assert.equal(bridge.publish("drive", {}), true);
  assert.deepEqual(warnings, ["client 7 does not hold control", "the connection was lost"]);
});

test("what waits behind a message that cannot be shown is heard", async () => {
  /** @type {unknown[]} */
  const told = [];
  globalThis.reportError = (error) => told.push(error);
  bridge.subscribe({
    topic: "gas", type: "telex_msgs/Gas", throttle: 0, heard: () => {
      throw new TypeError("no number");
    },
  });
  hear({ op: "publish", topic: "gas", msg: {} });
  hear({ op: "publish", topic: "bridge/clients", msg: { holder: "3", clients: [{ id: "3", name: "Bob" }] } });
  await beat();
  assert.equal(told.length, 1);
  assert.equal(control.holderName, "Bob");
});

test("who this page is is asked for until the slowest line has told it", async () => {
  /** @type {(number | undefined)[]} */
  const patience = [];
  bridge.call = async (service, args, within) => {
    patience.push(within);
    if (patience.length < 3) throw new DOMException("no answer", "TimeoutError");
    return { success: true, message: "9" };
  };
  control.disconnected();
  await control.connected();
  assert.ok(control.isKnown);
  assert.equal(patience.length, 3);
  assert.ok(Math.min(...patience.map(Number)) > 20000);
});

test("a bridge that refuses to tell it has no lock, and one that is lost is not asked again", async () => {
  let count = 0;
  bridge.call = async () => {
    count += 1;
    throw new Error("no such service");
  };
  await control.connected();
  assert.ok(!control.isKnown);
  bridge.call = async () => {
    count += 1;
    control.disconnected();
    throw new DOMException("no answer", "TimeoutError");
  };
  await control.connected();
  assert.equal(count, 2);
});
