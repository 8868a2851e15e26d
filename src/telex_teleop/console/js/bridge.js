// @ts-check
/** A small client of the rosbridge v2 protocol that reconnects by itself. */

import { atBeat } from "./beat.js";
import { stoodStill } from "./deadman.js";
import { term } from "./language/term.js";

const RETRY_AFTER = 1000; // ms between two attempts to connect
const PING_PERIOD = 500; // ms between two questions that only measure the link
const ANSWER_WITHIN = 5000; // ms after which a service call is given up, unless it says for itself
const TRIPS = 6; // round trips that tell how good the link is
const DEAD_AFTER = 3000; // ms without a message from the bridge after which the connection is given up
const CONNECT_WITHIN = 10000; // ms after which another attempt is made: a network that was gone answers the next one at once
const FIRST_WORD_WITHIN = 25000; // ms for the first one: on a slow line, request and answer take long

/**
 * Change (ms) of the wall clock against performance.now(), which may stand still in sleep, after which the bridge would take all
 * commands for old: it has to learn this page's clock again.
 */
const MAX_SKEW = 1000;

/**
 * @typedef {object} Subscription
 * @property {string} topic
 * @property {string} type
 * @property {number} throttle    Least time between two messages (ms).
 * @property {(message: any) => void} heard
 */

export class Bridge {
  /**
   * @param {() => Promise<string>} locate  Finds the bridge's address; asked anew before every attempt.
   * @param {object} events
   * @param {() => void} events.opened
   * @param {(reason: string) => void} events.lost     Called once per lost connection.
   * @param {(sentence: string) => void} events.refused  The bridge could not do what it was asked.
   */
  constructor(locate, events) {
    this._locate = locate;
    this._events = events;
    /** @type {WebSocket | null} */
    this._socket = null;
    /** @type {Map<string, {type: string, latch: boolean, urgent: boolean, held: boolean}>} */
    this._advertised = new Map();
    /** Number of calls under way during which only urgent topics are published. */
    this._alone = 0;
    /** @type {Map<string, Subscription>} */
    this._subscriptions = new Map();
    /** Messages that wait for the page's next beat. @type {{topic: string, msg: any}[]} */
    this._news = [];
    this._deliver = () => {
      for (const { topic, msg } of this._news.splice(0)) {
        try {
          this._subscriptions.get(topic)?.heard(msg);
        } catch (error) {
          reportError(error); // and what waits behind it is heard
        }
      }
    };
    /** Who waits for the answer of a service, by the id of the call. @type {Map<string, (answer: any) => void>} */
    this._calls = new Map();
    this._callNumber = 0;
    this._lastWord = 0;
    /** When the present connection was begun (ms). */
    this._began = 0;
    /** Whether the bridge has said anything since the connection was opened. */
    this._hasSpoken = false;
    /** Wall time less performance.now() (ms) since the connection was opened. */
    this._skew = 0;
    /** Whether the page has been left; it may come back as it was. */
    this._isLeft = false;
    /** The next attempt to connect. @type {ReturnType<typeof setTimeout> | undefined} */
    this._retry = undefined;
    this._pingSent = 0;
    this._pingNumber = 0;
    /** The last round trips to the bridge (ms), the newest last. @type {number[]} */
    this._trips = [];
  }

  /** Connect, and stay connected. */
  start() {
    setInterval(() => this._watch(), PING_PERIOD);
    // A browser may keep a page that was left, and its connection with the control of the robot.
    window.addEventListener("pagehide", () => this._leave());
    window.addEventListener("pageshow", () => this._comeBack());
    this._connect();
  }

  _leave() {
    this._isLeft = true;
    clearTimeout(this._retry);
    if (this._socket !== null) this._giveUp(term("the page was left"));
  }

  _comeBack() {
    if (!this._isLeft) return;
    this._isLeft = false;
    this._connect();
  }

  get connected() {
    return this._socket !== null && this._socket.readyState === WebSocket.OPEN;
  }

  /** Bytes that the browser has not got rid of yet. */
  get waiting() {
    return this._socket === null ? 0 : this._socket.bufferedAmount;
  }

  /** Round trip to the bridge (ms), at least as long as the present one has taken so far; null while unknown. */
  get roundTrip() {
    const last = this._trips.at(-1);
    return last === undefined ? null : Math.max(last, this._openTrip);
  }

  /**
   * The second longest of the last round trips (ms); null while unknown. What a link loses is sent again, and comes late, time and
   * again; a single late answer may be the page's own fault.
   */
  get usualTrip() {
    if (this._trips.length === 0) return null;
    // An answer that is still to come when the next question is due makes that one late, too.
    const open = this._openTrip > PING_PERIOD ? [this._openTrip, this._openTrip] : [];
    const [longest, second = longest] = [...this._trips, ...open].sort((a, b) => b - a);
    return second;
  }

  /** For how long (ms) the answer has been awaited by which the link is measured; 0 if none is. */
  get _openTrip() {
    return this._pingSent === 0 ? 0 : performance.now() - this._pingSent;
  }

  /** Time (ms) since the bridge said anything; Infinity while not connected. */
  get silence() {
    return this.connected ? performance.now() - this._lastWord : Infinity;
  }

  /**
   * @param {string} topic
   * @param {string} type
   * @param {{latch?: boolean, urgent?: boolean, held?: boolean}} [options]  Urgent: is published even during `callAlone`. Held: lasts
   *   as long as something is held, and is not published when the page has just stood still.
   */
  advertise(topic, type, { latch = false, urgent = false, held = false } = {}) {
    this._advertised.set(topic, { type, latch, urgent, held });
    if (this.connected) this._advertiseNow(topic);
  }

  /**
   * Publish on an advertised topic; without a connection, or during `callAlone`, the message is dropped, as is one of
   * what is held after a standstill of the page.
   * @param {string} topic
   * @param {object} msg
   * @returns {boolean} Whether it was sent.
   */
  publish(topic, msg) {
    const { urgent = false, held = false } = this._advertised.get(topic) ?? {};
    if (this._alone > 0 && !urgent) return false;
    // The page may have been stopped since what is held was looked at. If it is from here on, the bridge finds the message too old.
    const sent = performance.now();
    if (held && stoodStill(sent)) return false;
    return this._send({ op: "publish", topic, msg }, sent);
  }

  /**
   * Call a service that changes the meaning of what this page publishes; publish nothing until it is answered.
   * @param {string} service
   * @param {object} args
   * @returns {Promise<any>} As of `call`.
   */
  async callAlone(service, args) {
    this._alone += 1;
    try {
      return await this.call(service, args);
    } finally {
      this._alone -= 1;
    }
  }

  /**
   * Call a service.
   * @param {string} service
   * @param {object} args
   * @param {number} [within]  Time (ms) after which it is given up.
   * @returns {Promise<any>} Its answer; rejected when there is none, with a TimeoutError when there is none in time.
   */
  call(service, args, within = ANSWER_WITHIN) {
    this._callNumber += 1;
    const id = `call:${this._callNumber}`;
    return new Promise((resolve, reject) => {
      const end = (/** @type {() => void} */ settle) => {
        clearTimeout(timer);
        this._calls.delete(id);
        settle();
      };
      const timer = setTimeout(() => end(() => reject(new DOMException(`no answer within ${within / 1000} s`, "TimeoutError"))), within);
      this._calls.set(id, ({ result, values }) => end(() => {
        if (result) resolve(values);
        else reject(new Error(typeof values === "string" ? values : term("the call failed")));
      }));
      if (!this._send({ op: "call_service", id, service, args })) end(() => reject(new Error(term("not connected"))));
    });
  }

  /** @param {Subscription} subscription */
  subscribe(subscription) {
    this._subscriptions.set(subscription.topic, subscription);
    if (this.connected) this._subscribeNow(subscription);
  }

  /** Ask anew for all that is listened to: what was closed may be open by now. */
  subscribeAnew() {
    for (const subscription of this._subscriptions.values()) this._subscribeNow(subscription);
  }

  /** @param {string} topic */
  unsubscribe(topic) {
    if (this._subscriptions.delete(topic)) this._send({ op: "unsubscribe", id: `subscribe:${topic}`, topic });
  }

  /** @param {string} topic */
  _advertiseNow(topic) {
    const { type, latch } = /** @type {{type: string, latch: boolean}} */ (this._advertised.get(topic));
    // One message may wait for a slow subscriber, not a hundred: an old command is worse than none.
    this._send({ op: "advertise", id: `advertise:${topic}`, topic, type, latch, queue_size: 1 });
  }

  /** @param {Subscription} subscription */
  _subscribeNow({ topic, type, throttle }) {
    this._send({
      op: "subscribe", id: `subscribe:${topic}`, topic, type, throttle_rate: throttle, queue_length: 1,
    });
  }

  /**
   * @param {object} operation
   * @param {number} [sent]  When (ms): by this the bridge knows a command that was held up on its way, and drops it.
   * @returns {boolean}
   */
  _send(operation, sent = performance.now()) {
    if (!this.connected) return false;
    /** @type {WebSocket} */ (this._socket).send(JSON.stringify({ ...operation, sent }));
    return true;
  }

  async _connect() {
    let socket;
    try {
      const url = await this._locate();
      // It may have been left meanwhile, and even be connected anew.
      if (this._isLeft || this._socket !== null) return;
      socket = new WebSocket(url);
    } catch {
      this._connectLater();
      return;
    }
    this._socket = socket;
    this._began = performance.now();
    socket.onopen = () => {
      this._lastWord = performance.now();
      this._hasSpoken = false;
      this._skew = Date.now() - performance.now();
      this._trips = [];
      this._pingSent = 0;
      for (const topic of this._advertised.keys()) this._advertiseNow(topic);
      for (const subscription of this._subscriptions.values()) this._subscribeNow(subscription);
      this._events.opened();
    };
    socket.onmessage = ({ data }) => {
      if (socket === this._socket) this._receive(JSON.parse(data));
    };
    socket.onclose = () => {
      if (socket === this._socket) this._giveUp(term("the connection was closed"));
    };
  }

  /** @param {any} operation */
  _receive(operation) {
    this._lastWord = performance.now();
    this._hasSpoken = true;
    if (operation.op === "publish") {
      this._news.push(operation);
      // A page that nobody sees has its timers slowed down.
      if (document.hidden) this._deliver();
      else atBeat(this._deliver);
    } else if (operation.op === "service_response" && operation.id === `ping:${this._pingNumber}`) {
      this._trips = [...this._trips, this._openTrip].slice(-TRIPS);
      this._pingSent = 0;
    } else if (operation.op === "service_response") {
      this._calls.get(operation.id)?.(operation);
    } else if (operation.op === "status") {
      this._events.refused(operation.msg);
    }
  }

  _watch() {
    if (!this.connected) {
      // Also what closes without having been open.
      if (this._socket !== null && performance.now() - this._began > CONNECT_WITHIN) this._giveUp(term("the bridge is silent"));
      return;
    }
    const skew = Date.now() - performance.now();
    if (Math.abs(skew - this._skew) > MAX_SKEW) {
      this._giveUp(term("the computer slept"));
    } else if (this.silence > (this._hasSpoken ? DEAD_AFTER : FIRST_WORD_WITHIN)) {
      this._giveUp(term("the bridge is silent"));
    } else if (this._pingSent === 0) {
      this._pingSent = performance.now();
      this._pingNumber += 1;
      this._send({ op: "call_service", id: `ping:${this._pingNumber}`, service: "/rosapi/get_time" });
    }
  }

  /**
   * Forget the present connection at once: closing one whose other end is dead can take minutes.
   * @param {string} reason
   */
  _giveUp(reason) {
    const socket = this._socket;
    this._socket = null;
    this._trips = [];
    this._news = [];
    socket?.close();
    for (const answer of [...this._calls.values()]) answer({ result: false, values: term("the connection was lost") });
    this._events.lost(reason);
    this._connectLater();
  }

  _connectLater() {
    clearTimeout(this._retry);
    if (!this._isLeft) this._retry = setTimeout(() => this._connect(), RETRY_AFTER);
  }
}
