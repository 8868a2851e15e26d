// @ts-check
/** Moves the instructor's camera by dragging and by the wheel. */

import { onClick } from "./buttons.js";
import { decimal, text } from "./language.js";
import { all, byId, check, setText } from "./panels.js";
import { getParameter } from "./parameters.js";

const TOPIC = "cameras/overview/view";
const TYPE = "telex_msgs/OverviewView";
export const OVERVIEW = "overview";

const TURN_RATE = 0.006; // rad/px
const MOVE_RATE = 0.0016; // of the distance, for a pixel
const ZOOM_RATE = 0.0012; // of the distance's logarithm, for a pixel of the wheel
const LINE = 20; // px that a line of the wheel counts, where a browser counts in lines
const NEAREST = 0.4, FARTHEST = 60; // m
const LOWEST = -0.1, HIGHEST = 1.5; // rad
const SEND_PERIOD = 40; // ms
const ECHO_WITHIN = 1000; // ms in which what this page has sent comes back to it

/** @typedef {"follow" | "orbit" | "fixed"} Mode */
/** @typedef {{mode: Mode, azimuth: number, elevation: number, distance: number, turn_rate: number, center: {x: number, y: number, z: number}}} View */

/** The simulator's default view, until another one is known. @type {View} */
const START = { mode: "follow", azimuth: 2.5, elevation: 0.45, distance: 3.2, turn_rate: 0, center: { x: 0, y: 0, z: 0.3 } };

const clamp = (/** @type {number} */ value, /** @type {number} */ least, /** @type {number} */ most) =>
  Math.min(most, Math.max(least, value));

/**
 * Turn about the vertical.
 * @param {{x: number, y: number, z: number}} point
 * @param {number} angle  rad
 */
function turned({ x, y, z }, angle) {
  const c = Math.cos(angle), s = Math.sin(angle);
  return { x: c * x - s * y, y: s * x + c * y, z };
}

export class OverviewControl {
  /**
   * @param {import("./bridge.js").Bridge} bridge
   * @param {(name: string) => string} topic
   * @param {() => string} shown  The camera that is shown large.
   */
  constructor(bridge, topic, shown) {
    this._bridge = bridge;
    this._topic = topic;
    this._shown = shown;
    this.view = START;
    /** Where the robot is (m), and how it is turned (rad). */
    this._robot = { x: 0, y: 0, z: 0, heading: 0 };
    this._wasHeard = false;
    this._changed = false;
    this._sent = -Infinity;
    /** Pointer that drags, and where it was. @type {{id: number, x: number, y: number} | null} */
    this._drag = null;
    this._listen(byId("picture"));
    for (const button of all("[data-view]", byId("view-modes"))) {
      onClick(button, () => this.setMode(/** @type {Mode} */ (button.dataset.view)));
    }
    this._show();
    setInterval(() => this._send(), SEND_PERIOD);
  }

  subscribe() {
    // Latched: a page that is opened later begins with the present view.
    this._bridge.advertise(this._topic(TOPIC), TYPE, { latch: true });
    this._bridge.subscribe({
      topic: this._topic(TOPIC), type: TYPE, throttle: 100, heard: (view) => {
        this._wasHeard = true;
        if (this._changed || performance.now() - this._sent < ECHO_WITHIN) return;
        this.view = view;
        this._show();
      },
    });
  }

  /** Ask where the camera starts, unless somebody has moved it. */
  async connected() {
    try {
      const start = await getParameter(this._bridge, this._topic("cameras/overview/start"));
      if (start === null || this._wasHeard || this._changed) return;
      const [x, y, z] = start.center ?? [START.center.x, START.center.y, START.center.z];
      this.view = { ...START, ...start, center: { x, y, z } };
      this._show();
    } catch {
      // START holds, which is the shipped value.
    }
  }

  /** @param {any} message  geometry_msgs/PoseStamped, of the robot */
  setRobot({ pose: { position, orientation: { x, y, z, w } } }) {
    this._robot = { ...position, heading: Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)) };
  }

  /**
   * Change how the camera follows the robot, from its present view.
   * @param {Mode} mode
   */
  setMode(mode) {
    const { mode: before } = this.view;
    if (mode === before) return;
    const { x, y, z, heading } = this._robot;
    let { azimuth, center } = this.view;
    if (before === "follow") {
      azimuth += heading;
      center = turned(center, heading);
    }
    // About the robot again, wherever the camera looked meanwhile.
    if (before === "fixed") center = { ...START.center };
    if (mode === "fixed") center = { x: center.x + x, y: center.y + y, z: center.z + z };
    if (mode === "follow") {
      azimuth -= heading;
      center = turned(center, -heading);
    }
    this._change({ mode, azimuth, center });
  }

  /** Show what can be done with the picture that is large. */
  refresh() {
    const isShown = this._shown() === OVERVIEW;
    byId("view").dataset.camera = this._shown();
    byId("view-modes").hidden = !isShown;
    const { mode, distance } = this.view;
    setText(byId("view-hint"), isShown ? `${text(mode)} · ${decimal(distance, 1)} m` : "");
  }

  /** @param {HTMLElement} picture */
  _listen(picture) {
    picture.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || this._shown() !== OVERVIEW) return;
      event.preventDefault();
      picture.setPointerCapture(event.pointerId);
      this._drag = { id: event.pointerId, x: event.clientX, y: event.clientY };
      byId("view").classList.add("dragging");
    });
    picture.addEventListener("pointermove", (event) => {
      if (this._drag === null || event.pointerId !== this._drag.id) return;
      const right = event.clientX - this._drag.x, down = event.clientY - this._drag.y;
      this._drag = { ...this._drag, x: event.clientX, y: event.clientY };
      if (event.shiftKey) this._move(right, down);
      else this._turn(right, down);
    });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      picture.addEventListener(end, () => {
        this._drag = null;
        byId("view").classList.remove("dragging");
      });
    }
    picture.addEventListener("wheel", (event) => {
      if (this._shown() !== OVERVIEW) return;
      event.preventDefault();
      const way = event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? event.deltaY : LINE * event.deltaY;
      this._change({ distance: clamp(this.view.distance * Math.exp(ZOOM_RATE * way), NEAREST, FARTHEST) });
    }, { passive: false });
  }

  /**
   * @param {number} right  px
   * @param {number} down   px
   */
  _turn(right, down) {
    const { azimuth, elevation } = this.view;
    this._change({
      azimuth: (azimuth - TURN_RATE * right) % (2 * Math.PI),
      elevation: clamp(elevation + TURN_RATE * down, LOWEST, HIGHEST),
    });
  }

  /**
   * Move the point that the camera looks at over the ground, as if the picture were dragged.
   * @param {number} right  px
   * @param {number} down   px
   */
  _move(right, down) {
    const { azimuth, distance, center } = this.view;
    const way = MOVE_RATE * distance;
    const c = Math.cos(azimuth), s = Math.sin(azimuth);
    this._change({ center: { x: center.x + way * (right * s - down * c), y: center.y - way * (right * c + down * s), z: center.z } });
  }

  /** @param {Partial<View>} changes */
  _change(changes) {
    this.view = { ...this.view, ...changes };
    this._changed = true;
    this._show();
  }

  _send() {
    if (!this._changed || !this._bridge.publish(this._topic(TOPIC), this.view)) return;
    this._changed = false;
    this._sent = performance.now();
  }

  _show() {
    check(all("[data-view]", byId("view-modes")), ({ dataset }) => dataset.view === this.view.mode);
    this.refresh();
  }
}
