// @ts-check
/** Charge of the robot's battery, how long it will last, and how far. */

import { decimal, text } from "./language.js";
import { byId, setText } from "./panels.js";

export const BATTERY = { topic: "battery", type: "sensor_msgs/BatteryState" };
export const BATTERY_RANGE = { topic: "battery/range", type: "std_msgs/Float64" };

/** Share of the charge below which it is shown as a warning. */
const LOW = 0.2;

/** Share by which a new message moves the mean current: the runtime must not jump with every motion. */
const RENEWAL = 0.1;

export class BatteryView {
  constructor() {
    /** Mean current that the robot takes (A); null: not known. @type {number | null} */
    this._current = null;
    /** How far the charge lasts (m); null: not known. @type {number | null} */
    this._range = null;
    /** Whether there is little left. */
    this.isLow = false;
  }

  /** @param {any} message  std_msgs/Float64 */
  setRange({ data }) {
    this._range = Number.isFinite(data) && data >= 0 ? data : null;
  }

  /** @param {any} message  sensor_msgs/BatteryState */
  set({ percentage, charge, current }) {
    // What is not measured comes as null, which compares as zero.
    const isKnown = Number.isFinite(percentage);
    const chip = byId("battery");
    chip.hidden = !isKnown;
    this.isLow = isKnown && percentage < LOW;
    if (!isKnown) return;
    if (Number.isFinite(current)) {
      const taken = Math.max(0, -current);
      this._current = this._current === null ? taken : this._current + RENEWAL * (taken - this._current);
    }
    chip.dataset.low = String(this.isLow);
    const minutes = runtime(charge, this._current);
    // There is room for one of them: for driving, the range matters.
    setText(byId("battery-text"), chargeText(percentage, this._range === null ? minutes : null, this._range));
    chip.title = text("Charge, how long it lasts at what the robot takes, and how far: {charge}", { charge: chargeText(percentage, minutes, this._range) });
  }
}

/** How long a charge (A h) lasts (min) at a current (A); null: nobody knows. @param {number} charge @param {number | null} current */
export function runtime(charge, current) {
  return current === null || !(current > 0) || !Number.isFinite(charge) ? null : (60 * charge) / current;
}

/** @param {number} share @param {number | null} minutes @param {number | null} [metres] */
export function chargeText(share, minutes, metres = null) {
  // The charge that is left is rounded down.
  const percent = `${Math.floor(100 * share + 1e-6)} %`;
  if (share <= 0) return text("EMPTY");
  return [percent, ...(minutes === null ? [] : [duration(Math.floor(minutes))]), ...(metres === null ? [] : [distance(metres)])].join(" · ");
}

/** @param {number} minutes */
function duration(minutes) {
  return minutes < 60 ? `${minutes} min` : `${Math.floor(minutes / 60)} h ${minutes % 60} min`;
}

/** In two digits: nobody knows it better. @param {number} metres */
function distance(metres) {
  const step = 10 ** Math.max(0, Math.floor(Math.log10(Math.max(metres, 1))) - 1);
  const whole = Math.floor(metres / step) * step;
  return whole < 1000 ? `${whole} m` : `${decimal(whole / 1000, 1, 0)} km`;
}
