// @ts-check
/**
 * Shows an MJPEG stream and knows how old its picture is.
 *
 * An <img> would show the stream, too, but tells nobody when it stalls; an operator who drives by the picture must know.
 */

const RETRY_AFTER = 1000; // ms between two attempts to get the stream
const RECONNECT_AFTER = 5000; // ms without data after which the stream is asked for anew
const STALLED_AFTER = 1000; // ms without a new picture after which it counts as stalled
const RATE_WINDOW = 2000; // ms over which the frame rate is counted

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
      if (length === null) throw new Error("a part of the stream has no length");
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

export class VideoView {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this._canvas = canvas;
    this._context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d", { alpha: false }));
    /** @type {string | null} */
    this._topic = null;
    /** @type {AbortController | null} */
    this._connection = null;
    this._lastData = 0;
    /** @type {Uint8Array | null} */
    this._next = null;
    this._decoding = false;
    /** Times (ms) of the last pictures. @type {number[]} */
    this._shown = [];
    /** Why there is no picture. */
    this.trouble = "waiting for the camera";
    setInterval(() => this._watch(), 500);
  }

  /**
   * Show another topic; null shows none.
   * @param {string | null} topic
   */
  show(topic) {
    if (topic === this._topic) return;
    this._topic = topic;
    this._connection?.abort();
    if (topic !== null && this._connection === null) this._run();
  }

  /** Time (ms) since the last picture; Infinity if there was none. */
  get age() {
    const last = this._shown.at(-1);
    return last === undefined ? Infinity : performance.now() - last;
  }

  get live() {
    return this.age < STALLED_AFTER;
  }

  /** Pictures per second. */
  get rate() {
    const since = performance.now() - RATE_WINDOW;
    return (this._shown.filter((time) => time > since).length / RATE_WINDOW) * 1000;
  }

  async _run() {
    while (this._topic !== null) {
      this._connection = new AbortController();
      try {
        await this._read(this._topic, this._connection.signal);
        this.trouble = "the stream has ended";
      } catch (error) {
        if (!this._connection.signal.aborted) this.trouble = String(/** @type {any} */ (error).message ?? error);
      }
      await new Promise((resolve) => setTimeout(resolve, RETRY_AFTER));
    }
    this._connection = null;
  }

  /**
   * @param {string} topic
   * @param {AbortSignal} signal
   */
  async _read(topic, signal) {
    this._lastData = performance.now();
    const reply = await fetch(`/stream?topic=${encodeURIComponent(topic)}`, { signal, cache: "no-store" });
    if (reply.status === 404) throw new Error("the camera is not there yet");
    if (!reply.ok || reply.body === null) throw new Error(`the video server says ${reply.status}`);
    this.trouble = "the camera sends nothing";
    const reader = reply.body.getReader();
    const multipart = new MultipartReader();
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return;
      this._lastData = performance.now();
      const newest = multipart.push(value).at(-1);
      if (newest !== undefined) {
        this._next = newest;
        if (!this._decoding) this._paint();
      }
    }
  }

  /** Decode and draw pictures, always the newest, until there is none left. */
  async _paint() {
    this._decoding = true;
    while (this._next !== null) {
      const jpeg = this._next;
      this._next = null;
      try {
        const bitmap = await createImageBitmap(new Blob([/** @type {any} */ (jpeg)], { type: "image/jpeg" }));
        if (this._canvas.width !== bitmap.width || this._canvas.height !== bitmap.height) {
          this._canvas.width = bitmap.width;
          this._canvas.height = bitmap.height;
        }
        this._context.drawImage(bitmap, 0, 0);
        bitmap.close();
        this._shown.push(performance.now());
        while (this._shown.length > 1 && this._shown[0] < performance.now() - RATE_WINDOW) this._shown.shift();
      } catch {
        this.trouble = "the camera's picture cannot be decoded";
      }
    }
    this._decoding = false;
  }

  _watch() {
    // A network that is cut says nothing; asking anew is the only way to find out.
    if (this._connection !== null && performance.now() - this._lastData > RECONNECT_AFTER) this._connection.abort();
  }
}
