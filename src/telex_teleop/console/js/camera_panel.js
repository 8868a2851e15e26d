// @ts-check
/** Zoom: commands to the camera that has one, and what the panel shows of it. */

import { decimal, text } from "./language.js";
import { byId, element, holdButton, row, rowsOf, setText } from "./panels.js";

const LONGEST_STEP = 100; // ms; after a longer time between two commands, nothing was held in between

const ECHO_WITHIN = 1000; // ms in which the factor may be one from before what this page has commanded last

const NUMBER = "std_msgs/Float64";

export class CameraCommander {
  /**
   * @param {import("./vocabulary.js").Vocabulary} vocabulary
   * @param {import("./bridge.js").Bridge} bridge
   * @param {(name: string) => string} topic
   * @param {() => boolean} congested
   */
  constructor(vocabulary, bridge, topic, congested) {
    this._bridge = bridge;
    this._topic = topic;
    this._congested = congested;
    this._zoom = 1;
    /** Where the camera that zooms is told to; empty: not known yet, or there is none. */
    this._zoomTopic = "";
    /** Its name. */
    this._zooms = "";
    /** Called when a camera is told to zoom. @type {(camera: string, factor: number) => void} */
    this.zoomed = () => {};
    this._zoomRate = vocabulary.zoomRate;
    this._mostZoom = vocabulary.maxZoom;
    this._last = -Infinity;
    this._zoomValue = element("span", "num", "–"); // until somebody says how far the camera is zoomed
    this._zoomValue.id = "zoom-value";
    for (const actions of rowsOf(vocabulary.find("zoom").filter(({ modes }) => modes.join() === "CAMERA"))) {
      byId("camera-rows").append(row("", text(actions[0].row), this._zoomValue, ...actions.map(holdButton)));
    }
  }

  /** Take, after every new connection, which camera zooms, and how far. @param {Record<string, {zoom_max: number | null}>} cameras */
  setCameras(cameras) {
    for (const [name, { zoom_max: most }] of Object.entries(cameras)) {
      if (most === null || !(most > 1)) continue;
      this._mostZoom = most;
      this._zooms = name;
      this._listenToZoom(this._topic(`cameras/${name}/zoom`));
      return;
    }
  }

  /** @param {string} topic */
  _listenToZoom(topic) {
    if (topic === this._zoomTopic) return;
    this._zoomTopic = topic;
    this._bridge.advertise(topic, NUMBER);
    this._bridge.subscribe({
      topic: `${topic}_factor`, type: NUMBER, throttle: 100, heard: ({ data }) => {
        // Others may zoom as well, but what arrives while this page zooms is its own echo.
        if (performance.now() - this._last > ECHO_WITHIN) this._take(data);
      },
    });
  }

  /** @param {import("./vocabulary.js").Demand[]} held */
  update(held) {
    let direction = 0;
    for (const action of held) if (action.kind === "zoom") direction += action.sign * (action.amount ?? 1);
    direction = Math.max(-1, Math.min(1, direction));
    if (direction === 0 || this._zoomTopic === "" || this._congested()) return;
    const now = performance.now();
    const step = now - this._last > LONGEST_STEP ? 20 : now - this._last;
    this._last = now;
    this._take(this._zoom * Math.exp((direction * this._zoomRate * step) / 1000));
    this._bridge.publish(this._zoomTopic, { data: this._zoom });
  }

  /** @param {number | null} factor */
  _take(factor) {
    if (factor === null || !Number.isFinite(factor)) return;
    this._zoom = Math.min(this._mostZoom, Math.max(1, factor));
    setText(this._zoomValue, `${decimal(this._zoom, 1)}×`);
    this.zoomed(this._zooms, this._zoom);
  }

  /** Whether a camera can zoom. @param {string} camera */
  zooms(camera) {
    return camera === this._zooms;
  }
}
