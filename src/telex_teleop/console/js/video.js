// @ts-check
/** Decodes pictures; draws those of one camera, and counts them. Runs in the video worker. */

import { term } from "./language/term.js";

const RATE_WINDOW = 2000; // ms over which the frame rate is counted
const LIVE_FOR = 1000; // ms

/**
 * @typedef {object} ViewReport  Times as Date.now() counts (ms).
 * @property {string | null} camera
 * @property {number | null} drawn     When its last picture was drawn; null: none was.
 * @property {number | null} captured  When the scene of that picture was; null: not known.
 * @property {number | null} latency   How old the scene was when it was drawn (ms); null: not known.
 * @property {number | null} width     Of its last picture (px), as it came; null: none has come to this view.
 * @property {number} rate             Pictures per second.
 * @property {string} trouble          Why there is no picture.
 */

/** @typedef {ImageBitmap | VideoFrame | OffscreenCanvas} Drawable */

/**
 * Decode a picture, by the quickest means that the browser has.
 * @param {Uint8Array} bytes
 * @returns {Promise<ImageBitmap | VideoFrame>}
 */
export async function decode(bytes) {
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

/**
 * @typedef {object} Shown  What a view showed of a camera, for the view that shows it from now on.
 * @property {OffscreenCanvas} picture
 * @property {number[]} drawn
 * @property {number | null} captured
 * @property {number | null} latency
 * @property {string} trouble
 */

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
    /** @type {number | null} */
    this._width = null;
    this.trouble = term("waiting for the camera");
  }

  /**
   * Let another view go on with the camera.
   * @returns {Shown}
   */
  leave() {
    const picture = new OffscreenCanvas(this._canvas.width, this._canvas.height);
    /** @type {OffscreenCanvasRenderingContext2D} */ (picture.getContext("2d", { alpha: false })).drawImage(this._canvas, 0, 0);
    return { picture, drawn: this._drawn, captured: this._captured, latency: this._latency, trouble: this.trouble };
  }

  /**
   * Show another camera, its last picture in another view until one comes for this view.
   * @param {string | null} camera
   * @param {Shown} [shown]
   */
  show(camera, shown) {
    this.camera = camera;
    this._drawn = shown?.drawn ?? [];
    this._captured = shown?.captured ?? null;
    this._latency = shown?.latency ?? null;
    this._width = null;
    this.trouble = shown?.trouble ?? term("waiting for the camera");
    if (shown === undefined) this._context.fillRect(0, 0, this._canvas.width, this._canvas.height);
    else this._paint(shown.picture, shown.picture.width, shown.picture.height);
  }

  /**
   * @param {ImageBitmap | VideoFrame} picture  Of this view's camera.
   * @param {number | null} captured  When its scene was (ms, performance.now()); null: not known.
   */
  draw(picture, captured) {
    const [width, height] = "displayWidth" in picture ? [picture.displayWidth, picture.displayHeight] : [picture.width, picture.height];
    this._paint(picture, width, height);
    this._width = width;
    const now = performance.now();
    this._captured = captured;
    this._latency = captured === null ? null : now - captured;
    this.trouble = term("the camera sends nothing");
    this._drawn.push(now);
    while (this._drawn.length > 1 && this._drawn[0] < now - RATE_WINDOW) this._drawn.shift();
  }

  /**
   * @param {Drawable} picture
   * @param {number} fullWidth  Its own size (px).
   * @param {number} fullHeight
   */
  _paint(picture, fullWidth, fullHeight) {
    const scale = Math.min(1, this._maxWidth / fullWidth);
    const width = Math.round(fullWidth * scale), height = Math.round(fullHeight * scale);
    if (this._canvas.width !== width || this._canvas.height !== height) {
      this._canvas.width = width;
      this._canvas.height = height;
    }
    this._context.drawImage(picture, 0, 0, width, height);
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
      width: this._width,
      rate: (this._drawn.filter((time) => time > now - RATE_WINDOW).length / RATE_WINDOW) * 1000,
      trouble: this.trouble,
    };
  }
}
