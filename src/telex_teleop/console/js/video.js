// @ts-check
/** Decodes and draws the pictures of one camera, and counts them. Runs in the video worker. */

const RATE_WINDOW = 2000; // ms over which the frame rate is counted
const LIVE_FOR = 1000; // ms

/** @typedef {CanvasRenderingContext2D | OffscreenCanvasRenderingContext2D} Context */

/**
 * @typedef {object} ViewReport  Times as Date.now() counts (ms).
 * @property {string | null} camera
 * @property {number | null} drawn     When its last picture was drawn; null: none was.
 * @property {number | null} captured  When the scene of that picture was; null: not known.
 * @property {number | null} latency   How old the scene was when it was drawn (ms); null: not known.
 * @property {number} rate             Pictures per second.
 * @property {string} trouble          Why there is no picture.
 */

/**
 * Decode a picture, by the quickest means that the browser has.
 * @param {Uint8Array} bytes
 * @returns {Promise<ImageBitmap | VideoFrame>}
 */
async function decode(bytes) {
  const type = bytes[0] === 0x89 ? "image/png" : "image/jpeg";
  // It takes half the time of the other, but only pages from this machine or from https have it.
  if ("ImageDecoder" in self) {
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
  /**
   * @param {OffscreenCanvas} canvas
   * @param {number} maxWidth  Larger pictures are drawn smaller (px): what nobody can see need not be composited.
   */
  constructor(canvas, maxWidth) {
    this._canvas = canvas;
    this._maxWidth = maxWidth;
    this._context = /** @type {OffscreenCanvasRenderingContext2D} */ (canvas.getContext("2d", { alpha: false }));
    /** Name of the camera. @type {string | null} */
    this.camera = null;
    /** Times (ms, performance.now()) at which the last pictures were drawn. @type {number[]} */
    this._drawn = [];
    /** When the scene of the last picture was (ms, performance.now()), if that is known. @type {number | null} */
    this._captured = null;
    /** @type {number | null} */
    this._latency = null;
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
   * Decode a picture of a camera.
   * @param {string} camera
   * @param {Uint8Array} bytes
   * @param {number | null} captured  When its scene was (ms, performance.now()); null: not known.
   * @returns {Promise<(() => void) | null>} Draws it, unless the view has turned to another camera meanwhile; call it once.
   */
  async decode(camera, bytes, captured) {
    try {
      const picture = await decode(bytes);
      return () => this._draw(camera, picture, captured);
    } catch {
      if (camera === this.camera) this.trouble = "the camera's picture cannot be decoded";
      return null;
    }
  }

  /**
   * @param {string} camera
   * @param {ImageBitmap | VideoFrame} picture
   * @param {number | null} captured
   */
  _draw(camera, picture, captured) {
    try {
      if (camera !== this.camera) return;
      const fullWidth = "displayWidth" in picture ? picture.displayWidth : picture.width;
      const fullHeight = "displayHeight" in picture ? picture.displayHeight : picture.height;
      const scale = Math.min(1, this._maxWidth / fullWidth);
      const width = Math.round(fullWidth * scale), height = Math.round(fullHeight * scale);
      if (this._canvas.width !== width || this._canvas.height !== height) {
        this._canvas.width = width;
        this._canvas.height = height;
      }
      this._context.drawImage(picture, 0, 0, width, height);
    } finally {
      picture.close();
    }
    const now = performance.now();
    this._captured = captured;
    this._latency = captured === null ? null : now - captured;
    this.trouble = "the camera sends nothing";
    this._drawn.push(now);
    while (this._drawn.length > 1 && this._drawn[0] < now - RATE_WINDOW) this._drawn.shift();
  }

  get live() {
    return performance.now() - (this._drawn.at(-1) ?? -Infinity) < LIVE_FOR;
  }

  /** @returns {ViewReport} */
  report() {
    const now = performance.now();
    const toDate = (/** @type {number | null | undefined} */ time) =>
      time === null || time === undefined ? null : Date.now() - now + time;
    return {
      camera: this.camera,
      drawn: toDate(this._drawn.at(-1)),
      captured: toDate(this._captured),
      latency: this._latency,
      rate: (this._drawn.filter((time) => time > now - RATE_WINDOW).length / RATE_WINDOW) * 1000,
      trouble: this.trouble,
    };
  }
}
