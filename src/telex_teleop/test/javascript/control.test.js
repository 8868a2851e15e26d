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
