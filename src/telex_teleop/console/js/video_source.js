// @ts-check
/** Gets the pictures of all cameras by the WebSocket, or as streams where it cannot be had. Runs in the video worker. */

import { readSnapshots, readStream } from "./mjpeg.js";
import { VideoLink } from "./video_link.js";

const RETRY_AFTER = 1000; // ms between two attempts to connect
const RETRY_WEBSOCKET_AFTER = 5000; // ms between two attempts while pictures come another way
const REFUSALS = 2; // attempts after which pictures are got another way

/** @typedef {{name: string, topic: string}} Camera */

/**
 * @typedef {object} VideoConfig  What the video server tells the page.
 * @property {string} namespace
 * @property {Camera[]} cameras
 * @property {string[]} hidden_cameras
 * @property {string} main_camera
 * @property {number} main_rate
 * @property {number} thumbnail_rate
 * @property {number} thumbnail_width  Most pixels that a small picture needs.
 */

/**
 * @typedef {object} SourceListener
 * @property {(cameras: Camera[]) => void} cameras  All that are published, whenever there are others.
 * @property {(camera: string, picture: Uint8Array, captured: number | null) => Promise<void>} picture
 *   Shows a picture; the next one of the camera comes when this is done.
 * @property {(camera: string | null, why: string) => void} complain  Says why a camera, or none of them, has no picture.
 */

export class VideoSource {
  /**
   * @param {string} url  Of the WebSocket.
   * @param {Record<string, string>} access  Parameters of every address: token, role and robot.
   * @param {VideoConfig} config
   * @param {SourceListener} listener
   */
  constructor(url, access, config, listener) {
    this._url = `${url}?${new URLSearchParams(access)}`;
    this._access = access;
    this._config = config;
    this._listener = listener;
    /** Topics by name. @type {Map<string, string>} */
    this._topics = new Map(config.cameras.map(({ name, topic }) => [name, topic]));
    /** What is shown, the large view first. @type {string[]} */
    this._shown = [];
    /** Once the server has said which cameras there are. @type {VideoLink | null} */
    this._link = null;
    /** The connection, or the attempt at one. @type {VideoLink | null} */
    this._attempt = null;
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this._retry = undefined;
    this._refusals = 0;
    /** While pictures come another way than by the link. @type {AbortController | null} */
    this._fallback = null;
    /** The large view's part of it, for its present camera. @type {AbortController | null} */
    this._fallbackCamera = null;
  }

  start() {
    let wasAnnounced = false;
    const link = this._attempt = new VideoLink(this._url, {
      cameras: (cameras) => {
        wasAnnounced = true;
        this._refusals = 0;
        this._endFallback();
        this._link = link;
        this._topics = new Map(cameras.map(({ name, topic }) => [name, topic]));
        this._listener.cameras(cameras);
        this._ask();
      },
      picture: (camera, picture, captured) => this._listener.picture(camera, picture, captured),
      closed: (reason) => {
        this._link = this._attempt = null;
        this._listener.complain(null, reason);
        if (!wasAnnounced) this._refusals += 1;
        if (this._refusals >= REFUSALS && this._fallback === null) this._startFallback();
        this._retry = setTimeout(() => this.start(), this._fallback === null ? RETRY_AFTER : RETRY_WEBSOCKET_AFTER);
      },
    });
  }

  /** Give up every connection, until `start`. */
  stop() {
    clearTimeout(this._retry);
    this._attempt?.close();
    this._link = this._attempt = null;
    this._endFallback();
  }

  /** What the server said last of the pictures that it has sent, by camera. */
  get served() {
    return this._link?.served ?? {};
  }

  /** @param {string[]} cameras  Of all views, the large one first. */
  show(cameras) {
    const turned = cameras[0] !== this._shown[0];
    this._shown = cameras;
    this._ask();
    if (turned) this._fallbackCamera?.abort();
  }

  _ask() {
    const { main_rate: mainRate, thumbnail_rate: rate, thumbnail_width: width } = this._config;
    this._link?.show(
      this._shown
        .map((camera, index) => (index === 0 ? { camera, rate: mainRate } : { camera, rate, width }))
        .filter(({ camera }) => this._topics.has(camera)),
    );
  }

  /** The large view as a stream, the small ones as single pictures in turns. */
  _startFallback() {
    const fallback = new AbortController();
    this._fallback = fallback;
    const streams = async () => {
      while (!fallback.signal.aborted) {
        const camera = this._shown[0] ?? this._config.main_camera;
        const topic = this._topics.get(camera) ?? `${this._config.namespace}/cameras/${camera}/image_raw`;
        const turn = new AbortController();
        this._fallbackCamera = turn;
        await readStream(
          topic,
          this._access,
          turn.signal,
          (picture) => this._listener.picture(camera, picture, null),
          (why) => this._listener.complain(camera, why),
        );
      }
    };
    const nameOf = (/** @type {string} */ topic) =>
      /** @type {string} */ ([...this._topics].find(([, each]) => each === topic)?.[0]);
    streams();
    readSnapshots(
      () => this._shown.slice(1).flatMap((camera) => this._topics.get(camera) ?? []),
      this._access,
      fallback.signal,
      (topic, picture) => this._listener.picture(nameOf(topic), picture, null),
      (topic, why) => this._listener.complain(nameOf(topic), why),
    );
  }

  _endFallback() {
    this._fallback?.abort();
    this._fallbackCamera?.abort();
    this._fallback = this._fallbackCamera = null;
  }
}
