// @ts-check
/** Pointing into the overview's picture: rays by the camera's calibration and its pose on the newest picture. */

import { byId } from "../../panels.js";
import { pointIn, rayThrough } from "./ray.js";

const POSE_PERIOD = 40, INFO_PERIOD = 1000; // ms
const DRAGGED = 8; // px

/** @typedef {import("./ray.js").Ray} Ray */

export class PicturePointer {
  /**
   * @param {import("../../bridge.js").Bridge} bridge
   * @param {(name: string) => string} topic
   * @param {() => boolean} isShown  Whether the large picture is the overview's.
   * @param {(from: Ray, to: Ray) => void} pointed  Told where somebody pressed, and where he let go.
   */
  constructor(bridge, topic, isShown, pointed) {
    this._bridge = bridge;
    this._topics = { pose: topic("cameras/overview/pose"), info: topic("cameras/overview/camera_info") };
    this._isShown = isShown;
    this._pointed = pointed;
    this._isOn = false;
    /** @type {import("./ray.js").CameraInfo | null} */
    this._info = null;
    /** @type {import("./ray.js").Pose | null} */
    this._pose = null;
    /** @type {{id: number, ray: Ray, x: number, y: number} | null} */
    this._press = null;
    this._listen(byId("view"));
  }

  /**
   * Let presses in the picture point at objects instead of moving the camera.
   * @param {boolean} isOn
   */
  set(isOn) {
    byId("view").dataset.pointing = String(isOn);
    if (isOn === this._isOn) return;
    this._isOn = isOn;
    if (!isOn) {
      for (const topic of Object.values(this._topics)) this._bridge.unsubscribe(topic);
      return;
    }
    this._bridge.subscribe({
      topic: this._topics.pose, type: "geometry_msgs/PoseStamped", throttle: POSE_PERIOD, heard: ({ pose }) => { this._pose = pose; },
    });
    this._bridge.subscribe({
      topic: this._topics.info, type: "sensor_msgs/CameraInfo", throttle: INFO_PERIOD, heard: (info) => { this._info = info; },
    });
  }

  /** @param {PointerEvent} event @returns {Ray | null} Null: it does not point into the picture, or the camera is not known yet. */
  _ray(event) {
    if (this._info === null || this._pose === null) return null;
    const at = pointIn(byId("picture").getBoundingClientRect(), this._info.width / this._info.height, event);
    return at === null ? null : rayThrough(this._info, this._pose, ...at);
  }

  /** @param {HTMLElement} view  Before the picture, which would be dragged. */
  _listen(view) {
    const isMeant = (/** @type {PointerEvent} */ event) => this._isOn && this._isShown() && event.target === byId("picture");
    view.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || !isMeant(event)) return;
      event.preventDefault();
      event.stopPropagation();
      const ray = this._ray(event);
      this._press = ray && { id: event.pointerId, ray, x: event.clientX, y: event.clientY };
    }, { capture: true });
    view.addEventListener("pointerup", (event) => {
      const press = this._press;
      this._press = null;
      if (press === null || press.id !== event.pointerId || !isMeant(event)) return;
      const ray = this._ray(event);
      if (ray === null) return;
      const dragged = Math.hypot(event.clientX - press.x, event.clientY - press.y) > DRAGGED;
      this._pointed(dragged ? press.ray : ray, ray);
    }, { capture: true });
  }
}
