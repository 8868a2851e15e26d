// @ts-check
/** Reads an MJPEG stream picture by picture, and single pictures: what serves where no WebSocket can be had. */

import { term } from "./language/term.js";

const RETRY_AFTER = 1000; // ms between two attempts to get the stream
const RECONNECT_AFTER = 5000; // ms without data after which the stream is asked for anew

/** Cuts a multipart stream into its parts by their Content-Length. */
export class MultipartReader {
  constructor() {
    this._bytes = new Uint8Array(0);
  }

  /**
   * @param {Uint8Array} chunk
   * @returns {Uint8Array[]} The parts that are complete now.
   */
  push(chunk) {
    const bytes = new Uint8Array(this._bytes.length + chunk.length);
    bytes.set(this._bytes);
    bytes.set(chunk, this._bytes.length);
    const parts = [];
    let start = 0;
    for (;;) {
      const head = endOfHead(bytes, start);
      if (head < 0) break;
      const text = new TextDecoder("latin1").decode(bytes.subarray(start, head));
      const length = /content-length:\s*(\d+)/i.exec(text);
      if (length === null) throw new Error(term("a part of the stream has no length"));
      const end = head + Number(length[1]);
      if (end > bytes.length) break;
      parts.push(bytes.slice(head, end));
      start = end;
    }
    this._bytes = bytes.slice(start);
    return parts;
  }
}

/**
 * @param {Uint8Array} bytes
 * @param {number} start
 * @returns {number} Index after the next blank line, -1 if there is none.
 */
function endOfHead(bytes, start) {
  for (let i = bytes.indexOf(13, start); i >= 0 && i + 3 < bytes.length; i = bytes.indexOf(13, i + 1)) {
    if (bytes[i + 1] === 10 && bytes[i + 2] === 13 && bytes[i + 3] === 10) return i + 4;
  }
  return -1;
}

/** Hands over the newest picture only: while one is being used, all but the last that come are forgotten. */
class Newest {
  /** @param {(picture: Uint8Array) => Promise<void>} use */
  constructor(use) {
    this._use = use;
    /** @type {Uint8Array | null} */
    this._next = null;
    this._busy = false;
  }

  /** @param {Uint8Array} picture */
  async offer(picture) {
    this._next = picture;
    if (this._busy) return;
    this._busy = true;
    while (this._next !== null) {
      const taken = this._next;
      this._next = null;
      await this._use(taken);
    }
    this._busy = false;
  }
}

/**
 * Read a stream until told to stop; one that ends or falls silent is asked for again.
 * @param {string} topic
 * @param {Record<string, string>} access  Further parameters of the address: token and role.
 * @param {AbortSignal} stop
 * @param {(picture: Uint8Array) => Promise<void>} use
 * @param {(why: string) => void} complain  Called with why there is no picture.
 */
export async function readStream(topic, access, stop, use, complain) {
  const newest = new Newest(use);
  while (!stop.aborted) {
    const attempt = new AbortController();
    const end = () => attempt.abort();
    stop.addEventListener("abort", end);
    let lastData = performance.now();
    // A network that is cut says nothing; asking anew is the only way to find out.
    const watch = setInterval(() => {
      if (performance.now() - lastData > RECONNECT_AFTER) end();
    }, 500);
    try {
      const reply = await ask("stream", topic, access, attempt.signal);
      complain(term("the camera sends nothing"));
      const reader = /** @type {ReadableStream<Uint8Array>} */ (reply.body).getReader();
      const multipart = new MultipartReader();
      for (;;) {
        const { done, value } = await reader.read();
        if (done) break;
        lastData = performance.now();
        const picture = multipart.push(value).at(-1);
        if (picture !== undefined) newest.offer(picture);
      }
      complain(term("the stream has ended"));
    } catch (error) {
      if (!attempt.signal.aborted) complain(String(/** @type {any} */ (error).message ?? error));
    }
    clearInterval(watch);
    stop.removeEventListener("abort", end);
    if (!stop.aborted) await new Promise((resolve) => setTimeout(resolve, RETRY_AFTER));
  }
}

/**
 * Read single pictures of several topics in turns, until told to stop.
 *
 * A stream for each would take all six connections that a browser opens to a host.
 * @param {() => string[]} topics
 * @param {Record<string, string>} access  Further parameters of the address: token and role.
 * @param {AbortSignal} stop
 * @param {(topic: string, picture: Uint8Array) => Promise<void>} use
 * @param {(topic: string, why: string) => void} complain
 */
export async function readSnapshots(topics, access, stop, use, complain) {
  while (!stop.aborted) {
    const turn = topics();
    for (const topic of turn) {
      if (stop.aborted) return;
      try {
        const reply = await ask("snapshot", topic, access, stop);
        await use(topic, new Uint8Array(await reply.arrayBuffer()));
      } catch (error) {
        if (!stop.aborted) complain(topic, String(/** @type {any} */ (error).message ?? error));
        await new Promise((resolve) => setTimeout(resolve, RETRY_AFTER / turn.length));
      }
    }
    if (turn.length === 0) await new Promise((resolve) => setTimeout(resolve, RETRY_AFTER));
  }
}

/**
 * @param {string} what
 * @param {string} topic
 * @param {Record<string, string>} access
 * @param {AbortSignal} signal
 */
async function ask(what, topic, access, signal) {
  const reply = await fetch(`/${what}?${new URLSearchParams({ topic, ...access })}`, { signal, cache: "no-store" });
  if (reply.status === 401) throw new Error(term("the video server asks for a token: open the page with ?token=…"));
  if (reply.status === 404) throw new Error(term("the camera is not there yet"));
  if (reply.status === 504) throw new Error(term("the camera sends nothing"));
  if (!reply.ok) throw new Error(`the video server says ${reply.status}`);
  return reply;
}
