// @ts-check
/** All cameras over one WebSocket; docs/engineer/video.md describes the protocol. */

import { term } from "./language/term.js";

const HEADER = 16; // bytes before the picture
const VERSION = 1;
const PING_PERIOD = 1000; // ms
const SILENT_AFTER = 5; // pings without a word in between after which the connection counts as lost
const CLOCK_SAMPLES = 10; // pings of which the quickest one tells the clocks' difference

/** What the server's clock says, told from pings: the quickest of the last ones was delayed least. */
export class ServerClock {
  constructor() {
    /** Round trip (ms), and server's wall time (ms) less performance.now(). @type {{trip: number, offset: number}[]} */
    this._samples = [];
  }

  /**
   * @param {number} sent  When the ping went out (ms, performance.now()).
   * @param {number} received  When the answer came.
   * @param {number} server  What the server's clock said (ms) when it answered.
   */
  add(sent, received, server) {
    this._samples.push({ trip: received - sent, offset: server - (sent + received) / 2 });
    if (this._samples.length > CLOCK_SAMPLES) this._samples.shift();
  }

  /**
   * @param {number} server  A time of the server's clock (ms).
   * @returns {number | null} The same as performance.now() counts; null before the first ping was answered.
   */
  toPage(server) {
    if (this._samples.length === 0) return null;
    const best = this._samples.reduce((a, b) => (b.trip < a.trip ? b : a));
    return server - best.offset;
  }
}

/**
 * @typedef {object} CameraWish
 * @property {string} camera
 * @property {number} rate
 * @property {number} [width]  Most pixels that are wanted.
 */

/**
 * @typedef {object} Listener
 * @property {(cameras: {name: string, topic: string}[]) => void} cameras  Told at first, and when there are others.
 * @property {(camera: string, picture: Uint8Array, captured: number | null) => Promise<void>} picture
 *   Shows a picture; the next one of the camera comes when this is done.
 * @property {(reason: string) => void} closed
 */

export class VideoLink {
  /**
   * @param {string} url
   * @param {Listener} listener
   */
  constructor(url, listener) {
    this._listener = listener;
    this._clock = new ServerClock();
    /** Names by index. @type {string[]} */
    this._names = [];
    /** The picture of each camera that is being shown. @type {Map<number, Promise<void>>} */
    this._shown = new Map();
    /** Pictures (camera's index, number) whose acknowledgement has not been sent. @type {[number, number][]} */
    this._used = [];
    /** What the server says of each camera's pictures. @type {Record<string, object>} */
    this.served = {};
    /** Pings since something came: a page that stood still has not been waiting meanwhile. */
    this._unanswered = 0;
    this._socket = new WebSocket(url);
    this._socket.binaryType = "arraybuffer";
    this._socket.onopen = () => this._ping();
    this._socket.onmessage = ({ data }) => this._receive(data);
    this._socket.onclose = () => this._end(term("the connection is lost"));
    this._timer = setInterval(() => this._watch(), PING_PERIOD);
  }

  /**
   * Say what is wanted from now on.
   * @param {CameraWish[]} wishes
   */
  show(wishes) {
    this._send({ show: wishes });
  }

  /** End it without a word to the listener. */
  close() {
    clearInterval(this._timer);
    this._timer = 0;
    this._socket.onclose = this._socket.onmessage = this._socket.onopen = null;
    this._socket.close();
  }

  /** @param {string} reason */
  _end(reason) {
    if (this._timer === 0) return;
    this.close();
    this._listener.closed(reason);
  }

  _watch() {
    // A network that is cut says nothing.
    if (this._unanswered >= SILENT_AFTER) this._end(term("the video server does not answer"));
    else this._ping();
  }

  _ping() {
    this._unanswered += 1;
    this._send({ ping: performance.now() });
  }

  /** @param {object} message */
  _send(message) {
    if (this._socket.readyState === WebSocket.OPEN) this._socket.send(JSON.stringify(message));
  }

  /** @param {string | ArrayBuffer} data */
  _receive(data) {
    const now = performance.now();
    this._unanswered = 0;
    if (typeof data !== "string") {
      this._receivePicture(data);
      return;
    }
    const message = JSON.parse(data);
    if (message.cameras !== undefined) {
      this._names = message.cameras.map((/** @type {{name: string}} */ { name }) => name);
      this._listener.cameras(message.cameras);
    } else if (message.pong !== undefined) {
      this._clock.add(message.pong, now, message.time * 1000);
      this.served = message.views;
    } else if (message.error !== undefined) {
      console.warn(`video server: ${message.error}`);
    }
  }

  /** @param {ArrayBuffer} data */
  _receivePicture(data) {
    const header = new DataView(data);
    if (data.byteLength < HEADER || header.getUint8(0) !== VERSION) return;
    const index = header.getUint8(1);
    const number = header.getUint32(4, true);
    const captured = header.getFloat64(8, true) * 1000;
    const name = this._names[index];
    const picture = new Uint8Array(data, HEADER);
    // Cameras do not wait for each other, but the pictures of one keep their order.
    const before = this._shown.get(index) ?? Promise.resolve();
    const shown = before
      .then(() => this._listener.picture(name, picture, this._clock.toPage(captured)))
      .finally(() => this._acknowledge(index, number));
    this._shown.set(index, shown);
  }

  /**
   * Acknowledge a picture, together with those that are drawn at the same time.
   * @param {number} index
   * @param {number} number
   */
  _acknowledge(index, number) {
    this._used.push([index, number]);
    if (this._used.length > 1) return;
    setTimeout(() => this._send({ ack: this._used.splice(0) }));
  }
}
