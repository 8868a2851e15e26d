// @ts-check
/** One large view and a small one for each of the other cameras, live, by whatever way their pictures come. */

import { readSnapshots, readStream } from "./mjpeg.js";
import { VideoView } from "./video.js";
import { VideoLink } from "./video_link.js";

const RETRY_AFTER = 1000; // ms between two attempts to connect
const RETRY_WEBSOCKET_AFTER = 5000; // ms between two attempts while pictures come another way
const REFUSALS = 2; // attempts after which pictures are got another way

/**
 * @typedef {object} VideoConfig  What the video server tells the page.
 * @property {string} namespace
 * @property {{name: string, topic: string}[]} cameras
 * @property {string[]} hidden_cameras
 * @property {string} main_camera
 * @property {number} main_rate
 * @property {number} thumbnail_rate
 */

/** A small view of a camera that becomes the large one by a click. */
class Thumbnail {
  /** @param {(camera: string) => void} choose */
  constructor(choose) {
    this.element = document.createElement("button");
    this.element.type = "button";
    this.element.className = "thumbnail";
    this.element.tabIndex = -1;
    const canvas = document.createElement("canvas");
    canvas.width = 320;
    canvas.height = 240;
    this._name = document.createElement("span");
    this._name.className = "hud thumbnail-name";
    this._note = document.createElement("span");
    this._note.className = "thumbnail-note num";
    this.element.append(canvas, this._name, this._note);
    // Like every button here it leaves the focus where it is: Space must never click it.
    this.element.addEventListener("pointerdown", (event) => event.preventDefault());
    this.element.addEventListener("mousedown", (event) => event.preventDefault());
    this.element.addEventListener("click", () => this.view.camera !== null && choose(this.view.camera));
    this.view = new VideoView(canvas);
  }

  /** @param {string} camera */
  show(camera) {
    if (camera === this.view.camera) return;
    this.view.show(camera);
    this._name.textContent = camera;
    this.element.dataset.camera = camera;
    this.element.title = `show ${camera} large`;
    this.refresh();
  }

  /** Show whether the picture is live. */
  refresh() {
    const { live, age } = this.view;
    this.element.dataset.state = live ? "live" : "stalled";
    const since = age < 100_000 ? ` ${(age / 1000).toFixed(1)} s` : "";
    this._note.textContent = live ? "" : `NO PICTURE${since}`;
  }
}

export class Cameras {
  /**
   * @param {VideoConfig} config
   * @param {HTMLCanvasElement} canvas  Of the large view.
   * @param {HTMLElement} column  Where the small ones go.
   * @param {(name: string) => void} named  Called with the camera that is shown large.
   */
  constructor(config, canvas, column, named) {
    this._config = config;
    this._column = column;
    this._named = named;
    this.main = new VideoView(canvas);
    /** @type {Thumbnail[]} */
    this._thumbnails = [];
    /** Topics by name. @type {Map<string, string>} */
    this._topics = new Map();
    /** @type {VideoLink | null} */
    this._link = null;
    this._refusals = 0;
    /** While pictures come another way than by the link. @type {AbortController | null} */
    this._fallback = null;
    /** The large view's part of it, for its present camera. @type {AbortController | null} */
    this._fallbackCamera = null;
    const camera = config.cameras.find(({ name }) => name === config.main_camera) ?? config.cameras[0];
    this.main.show(camera?.name ?? config.main_camera);
    this._named(/** @type {string} */ (this.main.camera));
    this._setCameras(config.cameras);
  }

  start() {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    let wasAnnounced = false;
    const link = new VideoLink(`${scheme}//${location.host}/video`, {
      cameras: (cameras) => {
        wasAnnounced = true;
        this._refusals = 0;
        this._endFallback();
        this._link = link;
        this._setCameras(cameras);
        this._ask();
      },
      picture: (camera, picture, captured) => this._draw(camera, picture, captured),
      closed: (reason) => {
        this._link = null;
        this._complain(null, reason);
        if (!wasAnnounced) this._refusals += 1;
        if (this._refusals >= REFUSALS && this._fallback === null) this._startFallback();
        setTimeout(() => this.start(), this._fallback === null ? RETRY_AFTER : RETRY_WEBSOCKET_AFTER);
      },
    });
  }

  /** Show which views are live. */
  refresh() {
    for (const thumbnail of this._thumbnails) thumbnail.refresh();
  }

  /** @param {{name: string, topic: string}[]} cameras  All that are published. */
  _setCameras(cameras) {
    for (const { name, topic } of cameras) {
      if (!this._config.hidden_cameras.includes(name)) this._topics.set(name, topic);
    }
    const shown = new Set([this.main.camera, ...this._thumbnails.map(({ view }) => view.camera)]);
    for (const name of this._topics.keys()) {
      if (shown.has(name)) continue;
      const thumbnail = new Thumbnail((camera) => this._choose(camera));
      thumbnail.show(name);
      this._thumbnails.push(thumbnail);
      this._column.append(thumbnail.element);
    }
    this._column.style.setProperty("--thumbnails", String(Math.max(5, this._thumbnails.length)));
    for (const view of this._views()) {
      const isKnown = view.camera !== null && this._topics.has(view.camera);
      if (!view.live) view.trouble = isKnown ? "the camera sends nothing" : "the camera is not there yet";
    }
  }

  _views() {
    return [this.main, ...this._thumbnails.map(({ view }) => view)];
  }

  /**
   * Show another camera large; the one that was takes its place.
   * @param {string} camera
   */
  _choose(camera) {
    const thumbnail = this._thumbnails.find(({ view }) => view.camera === camera);
    if (thumbnail === undefined || this.main.camera === null) return;
    const before = this.main.camera;
    this.main.show(camera);
    thumbnail.show(before);
    this._named(camera);
    this._ask();
    this._fallbackCamera?.abort();
  }

  _ask() {
    const { main_rate: mainRate, thumbnail_rate: thumbnailRate } = this._config;
    this._link?.show(
      this._views()
        .filter(({ camera }) => camera !== null && this._topics.has(camera))
        .map((view) => ({
          camera: /** @type {string} */ (view.camera),
          rate: view === this.main ? mainRate : thumbnailRate,
        })),
    );
  }

  /**
   * @param {string} camera
   * @param {Uint8Array} picture
   * @param {number | null} captured
   */
  async _draw(camera, picture, captured) {
    await this._views()
      .find((view) => view.camera === camera)
      ?.draw(camera, picture, captured);
  }

  /**
   * @param {string | null} camera  null: all of them.
   * @param {string} why
   */
  _complain(camera, why) {
    for (const view of this._views()) {
      if (camera === null || view.camera === camera) view.trouble = why;
    }
  }

  /** The large view as a stream, the small ones as single pictures in turns. */
  _startFallback() {
    const fallback = new AbortController();
    this._fallback = fallback;
    const streams = async () => {
      while (!fallback.signal.aborted) {
        const camera = /** @type {string} */ (this.main.camera);
        const topic = this._topics.get(camera) ?? `${this._config.namespace}/cameras/${camera}/image_raw`;
        const turn = new AbortController();
        this._fallbackCamera = turn;
        await readStream(
          topic,
          turn.signal,
          (picture) => this._draw(camera, picture, null),
          (why) => this._complain(camera, why),
        );
      }
    };
    const nameOf = (/** @type {string} */ topic) =>
      /** @type {string} */ ([...this._topics].find(([, each]) => each === topic)?.[0]);
    streams();
    readSnapshots(
      () => this._thumbnails.map(({ view }) => /** @type {string} */ (this._topics.get(view.camera ?? ""))),
      fallback.signal,
      (topic, picture) => this._draw(nameOf(topic), picture, null),
      (topic, why) => this._complain(nameOf(topic), why),
    );
  }

  _endFallback() {
    this._fallback?.abort();
    this._fallbackCamera?.abort();
    this._fallback = this._fallbackCamera = null;
  }
}
