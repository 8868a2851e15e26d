// @ts-check
/** The emergency stop over a connection that is lost. */

import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";

import { clock, paced } from "./browser.js";
import { Bridge } from "../../console/js/bridge.js";
import { EmergencyStop } from "../../console/js/emergency_stop.js";
import { RobotsPanel } from "../../console/js/instructor/robots_panel.js";

const ALARM = "not connected: e-stop was NOT sent";
const SILENCE = 4000; // ms, more than a connection may be silent

/** @type {FakeSocket[]} */
let sockets;
/** @type {(() => void)[]} */
let timers;
/** @type {string[]} */
let alarms;
/** @type {EmergencyStop} */
let stop;

class FakeSocket {
  static OPEN = 1;
  readyState = 0;
  bufferedAmount = 0;
  /** @type {any[]} */
  sent = [];

  constructor() {
    sockets.push(this);
  }

  /** @param {string} message */
  send(message) {
    this.sent.push(JSON.parse(message));
  }

  close() {
    this.readyState = 3;
  }

  open() {
    this.readyState = FakeSocket.OPEN;
    /** @type {any} */ (this).onopen();
    /** @type {any} */ (this).onmessage({ data: JSON.stringify({ op: "service_response", id: "first word" }) });
  }

  /** What was asked of the emergency stop over this connection. */
  get asked() {
    return this.sent.filter(({ op }) => op === "publish").map(({ msg }) => msg.data);
  }
}

Object.assign(globalThis, { WebSocket: FakeSocket, setTimeout: (/** @type {() => void} */ timer) => timers.push(timer), clearTimeout() {} });
Object.defineProperty(Date, "now", { value: () => 1e12 + clock.now });

/** Connect anew, as the bridge does by itself after a while. */
async function connect() {
  timers.splice(0).forEach((timer) => timer());
  await new Promise((resolve) => setImmediate(resolve));
  const socket = /** @type {FakeSocket} */ (sockets.at(-1));
  socket.open();
  return socket;
}

/** The network dies: nothing more is heard, and after a while the connection is given up. */
function die() {
  clock.now += SILENCE;
  paced.forEach((watch) => watch());
}

beforeEach(() => {
  [sockets, timers, alarms] = [[], [], []];
  paced.splice(0);
  Object.assign(globalThis, { window: { addEventListener() {} } });
  /** @type {Bridge} */
  const bridge = new Bridge(async () => "", { opened: () => stop.connected(), lost: () => stop.lost(), refused() {} });
  stop = new EmergencyStop(bridge, "/telex/e_stop", (sentence) => alarms.push(sentence));
  stop.advertise();
  bridge.start();
});

test("what a dead network took is told, and sent again when there is a connection", async () => {
  const first = await connect();
  stop.set(true);
  assert.deepEqual(first.asked, [true]);
  assert.deepEqual(alarms, []);
  die();
  assert.deepEqual(alarms, [ALARM]);
  assert.deepEqual((await connect()).asked, [true]);
  die();
  assert.deepEqual(alarms, [ALARM, ALARM]);
  assert.deepEqual((await connect()).asked, [true]);
});

test("what the simulator has said to be set is sent no more, also after its release", async () => {
  await connect();
  stop.hear({ e_stop: false });
  stop.set(true);
  stop.hear({ e_stop: false }); // on its way before
  stop.hear({ e_stop: true });
  stop.hear({ e_stop: false });
  die();
  assert.deepEqual((await connect()).asked, []);
  assert.deepEqual(alarms, []);
});

test("a release ends it", async () => {
  const first = await connect();
  stop.set(true);
  stop.set(false);
  assert.deepEqual(first.asked, [true, false]);
  die();
  assert.deepEqual((await connect()).asked, []);
  assert.deepEqual(alarms, []);
});

test("what was said before its release does not confirm the next one", async () => {
  await connect();
  stop.set(true);
  stop.hear({ e_stop: true });
  stop.set(false);
  stop.set(true);
  stop.hear({ e_stop: true }); // on its way before
  die();
  assert.deepEqual(alarms, [ALARM]);
  assert.deepEqual((await connect()).asked, [true]);
  stop.hear({ e_stop: false });
  stop.hear({ e_stop: true });
  die();
  assert.deepEqual((await connect()).asked, []);
});

test("what is set without a connection is told once, and sent with the next one", async () => {
  await connect();
  die();
  stop.set(true);
  die();
  stop.lost(); // an attempt to connect has failed
  assert.deepEqual(alarms, [ALARM]);
  assert.deepEqual((await connect()).asked, [true]);
});

test("a release without a connection is told, and not sent later", async () => {
  await connect();
  die();
  stop.set(false);
  assert.deepEqual(alarms, [ALARM]);
  assert.deepEqual((await connect()).asked, []);
});

test("the other robots of a scene are stopped as surely", async () => {
  const made = () => ({ dataset: {}, append() {}, addEventListener() {} });
  Object.assign(globalThis, {
    document: { hidden: true, createElement: made, getElementById: made },
    fetch: async () => ({ ok: true, json: async () => ({ rosbridge: "ws://there:9090" }) }),
  });
  /** @type {string[]} */
  const log = [];
  const config = /** @type {any} */ ({ namespace: "/telex", robots: [{ name: "telex" }, { name: "telex_b" }] });
  const panel = new RobotsPanel(config, new URLSearchParams(), (sentence) => log.push(sentence));
  const first = await connect();
  panel.stopAll();
  assert.deepEqual(first.asked, [true]);
  die();
  assert.equal(log.at(-1), `telex_b: ${ALARM}`);
  const second = await connect();
  assert.deepEqual(second.asked, [true]);
  /** @type {any} */ (second).onmessage({ data: JSON.stringify({ op: "publish", topic: "/telex_b/sim/status", msg: { e_stop: true } }) });
  die();
  assert.deepEqual((await connect()).asked, []);
});

for (const [fate, lose] of /** @type {[string, () => void][]} */ ([
  ["was not sent", () => { die(); stop.set(false); }],
  ["a dead network took", () => { stop.set(false); die(); }],
])) {
  test(`a release that ${fate} keeps no later stop from being confirmed`, async () => {
    await connect();
    stop.set(true);
    stop.hear({ e_stop: true });
    lose();
    await connect();
    stop.set(true);
    stop.hear({ e_stop: true });
    stop.hear({ e_stop: false }); // released by somebody else
    die();
    assert.deepEqual((await connect()).asked, []);
  });
}

test("an attempt to connect that is not answered is given up, and another one made", async () => {
  await new Promise((resolve) => setImmediate(resolve));
  assert.equal(sockets.length, 1);
  stop.set(true);
  die();
  assert.deepEqual([sockets[0].readyState, timers.length], [0, 0]);
  die();
  die();
  assert.equal(sockets[0].readyState, 3);
  assert.deepEqual((await connect()).asked, [true]);
  assert.equal(sockets.length, 2);
});
