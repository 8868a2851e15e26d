// @ts-check
/** Shows the pictures of a camera, and knows how old they are: an operator who drives by them must know. */

export const STALLED_AFTER = 1000; // ms without a new picture after which a view counts as stalled
const RATE_WINDOW = 2000; // ms over which the frame rate is counted

/**
 * Decode a picture, by the quickest means that the browser has.
 * @param {Uint8Array} bytes
 * @returns {Promise<ImageBitmap | VideoFrame>}
 */
async function decode(bytes) {
  const type = bytes[0] === 0x89 ? "image/png" : "image/jpeg";
  // It takes half the time of the other, but only pages from this machine or from https have it.
  if ("ImageDecoder" in window) {
    const decoder = new ImageDecoder({ data: /** @type {any} */ (bytes), type });
    try {
      return (await decoder.decode()).image;
    } finally {
      decoder.close();
    }
  }
  return createImageBitmap(new Blob([/** @type {any} */ (bytes)], { type }));
}

export class VideoView {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this._canvas = canvas;
    this._context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d", { alpha: false }));
    /** Name of the camera. @type {string | null} */
    this.camera = null;
    /** Times (ms) at which the last pictures were drawn. @type {number[]} */
    this._drawn = [];
    /** When the scene of the last picture was (ms, as performance.now() counts), if that is known. */
    this._captured = /** @type {number | null} */ (null);
    /** How old the scene of the last picture was (ms) when it was drawn, if that is known. */
    this._latency = /** @type {number | null} */ (null);
    /** Why there is no picture. */
    this.trouble = "waiting for the camera";
  }

  /**
   * Show another camera.
   * @param {string | null} camera
   */
  show(camera) {
    if (camera === this.camera) return;
    this.camera = camera;
    this._drawn = [];
    this._captured = this._latency = null;
    this.trouble = "waiting for the camera";
    this._context.fillRect(0, 0, this._canvas.width, this._canvas.height);
  }

  /**
   * Draw a picture of a camera, unless the view has turned to another one meanwhile.
   * @param {string} camera
   * @param {Uint8Array} bytes
   * @param {number | null} captured  When its scene was (ms, as performance.now() counts); null: not known.
   */
  async draw(camera, bytes, captured) {
    let picture;
    try {
      picture = await decode(bytes);
    } catch {
      if (camera === this.camera) this.trouble = "the camera's picture cannot be decoded";
      return;
    }
    try {
      if (camera !== this.camera) return;
      const width = "displayWidth" in picture ? picture.displayWidth : picture.width;
      const height = "displayHeight" in picture ? picture.displayHeight : picture.height;
      if (this._canvas.width !== width || this._canvas.height !== height) {
        this._canvas.width = width;
        this._canvas.height = height;
      }
      this._context.drawImage(picture, 0, 0);
    } finally {
      picture.close();
    }
    const now = performance.now();
    this._captured = captured;
    this._latency = captured === null ? null : now - captured;
    this.trouble = "the camera sends nothing";
    this._drawn.push(now);
    while (this._drawn.length > 1 && this._drawn[0] < now - RATE_WINDOW) this._drawn.shift();
    this._canvas.dispatchEvent(new CustomEvent("drawn", { detail: { camera, captured } }));
  }

  /** Time (ms) since the last picture was drawn; Infinity if there was none. */
  get silence() {
    const last = this._drawn.at(-1);
    return last === undefined ? Infinity : performance.now() - last;
  }

  /** Age (ms) of the scene that is shown, as well as it is known; Infinity if there is none. */
  get age() {
    if (this._captured === null) return this.silence;
    return Math.max(this.silence, performance.now() - this._captured);
  }

  get live() {
    return this.age < STALLED_AFTER;
  }

  /** How old the scene was (ms) when it was drawn; null where only its picture's arrival is known. */
  get latency() {
    return this._latency;
  }

  /** Pictures per second. */
  get rate() {
    const since = performance.now() - RATE_WINDOW;
    return (this._drawn.filter((time) => time > since).length / RATE_WINDOW) * 1000;
  }
}
