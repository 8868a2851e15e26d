// @ts-check
/** Calibrations of the cameras that are shown large, each asked for once: who listens on has them drawn in full size all the time. */

import { text, translated } from "../language.js";
import { lensOf, zoomed } from "./lens.js";

const TYPE = "sensor_msgs/CameraInfo";

const RESTED = 500; // ms after the last word on a zoom, after which the calibration is asked for anew

/** @typedef {import("./lens.js").Lens} Lens */
/** @typedef {{lens: Lens, frame: string}} Calibration  `frame`: the optical frame. */

/**
 * @typedef {object} Known  Of a camera.
 * @property {"unknown" | "asked" | "told" | "refused"} state
 * @property {Calibration | null} calibration
 * @property {number | null} zoom    Told last; null: nobody has said.
 * @property {number | null} taken   Zoom when the calibration was told.
 * @property {ReturnType<typeof setTimeout> | undefined} timer
 */

export class Calibrations {
  /**
   * @param {import("../bridge.js").Bridge} bridge
   * @param {(name: string) => string} topic
   * @param {(sentence: string) => void} warn
   */
  constructor(bridge, topic, warn) {
    this._bridge = bridge;
    this._topic = topic;
    this._warn = warn;
    /** @type {Map<string, Known>} */
    this._known = new Map();
    /** Called when there is another one. */
    this.changed = () => {};
  }

  /** @param {string} camera @returns {Known} */
  _of(camera) {
    const known = this._known.get(camera) ?? { state: "unknown", calibration: null, zoom: null, taken: null, timer: undefined };
    this._known.set(camera, known);
    return known;
  }

  /** Forget all: after a new connection, they may be others. */
  forget() {
    for (const [camera, known] of this._known) {
      this._end(camera, known);
      Object.assign(known, { state: "unknown", calibration: null });
    }
  }

  /**
   * Calibrations of cameras as they are zoomed now, null while unknown. They are asked for, and those of no other ones any more.
   * @param {string[]} cameras
   * @returns {(Calibration | null)[]}
   */
  of(cameras) {
    for (const [camera, known] of this._known) if (!cameras.includes(camera)) this._end(camera, known);
    return cameras.map((camera) => {
      const { state, calibration, zoom, taken } = this._of(camera);
      if (state === "unknown") this._ask(camera);
      if (calibration === null || zoom === taken) return calibration;
      // Where it is not known with which zoom it was told, it tells nothing of another one.
      return zoom === null || taken === null ? null : { ...calibration, lens: zoomed(calibration.lens, zoom / taken) };
    });
  }

  /** Zoom of a camera as was told last; null: nobody has said. @param {string} camera */
  zoom(camera) {
    return this._of(camera).zoom;
  }

  /** @param {string} camera @param {number} factor */
  hearZoom(camera, factor) {
    const known = this._of(camera);
    if (known.zoom === factor) return;
    known.zoom = factor;
    if (known.taken === null && known.state === "told") known.state = "unknown";
    // Once it rests, what the camera says counts.
    clearTimeout(known.timer);
    known.timer = setTimeout(() => {
      if (known.state === "told") known.state = "unknown";
      this.changed();
    }, RESTED);
    this.changed();
  }

  /** @param {string} camera */
  _ask(camera) {
    if (!this._bridge.connected) return;
    const known = this._of(camera);
    known.state = "asked";
    this._bridge.subscribe({
      topic: this._topicOf(camera), type: TYPE, throttle: 0, heard: (info) => {
        if (known.state !== "asked") return;
        this._end(camera, known);
        this._take(camera, known, info);
      },
    });
  }

  /** @param {string} camera @param {Known} known @param {any} info  sensor_msgs/CameraInfo */
  _take(camera, known, info) {
    try {
      known.calibration = { lens: lensOf(info), frame: info.header.frame_id };
      known.taken = known.zoom;
      known.state = "told";
    } catch (error) {
      known.calibration = null;
      known.state = "refused"; // until the next connection
      this._warn(text("camera {camera}: {why}; nothing is drawn into its picture", { camera: translated(camera), why: translated(/** @type {Error} */ (error).message) }));
    }
    this.changed();
  }

  /** Ask no more. @param {string} camera @param {Known} known */
  _end(camera, known) {
    if (known.state !== "asked") return;
    known.state = "unknown";
    this._bridge.unsubscribe(this._topicOf(camera));
  }

  /** @param {string} camera */
  _topicOf(camera) {
    return this._topic(`cameras/${camera}/camera_info`);
  }
}
