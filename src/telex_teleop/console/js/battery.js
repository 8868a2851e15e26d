// @ts-check
/** Charge of the robot's battery, and how long it will last. */

import { byId, setText } from "./panels.js";

export const BATTERY = { topic: "battery", type: "sensor_msgs/BatteryState" };

/** Share of the charge below which it is shown as a warning. */
const LOW = 0.2;

/** Share by which a new message moves the mean current: the runtime must not jump with every motion. */
const RENEWAL = 0.1;

export class BatteryView {
  constructor() {
    /** Mean current that the robot takes (A); null: not known. @type {number | null} */
    this._current = null;
  }

  /** @param {any} message  sensor_msgs/BatteryState */
  set({ percentage, charge, current }) {
    const chip = byId("battery");
    chip.hidden = !Number.isFinite(percentage);
    if (chip.hidden) return;
    const taken = Math.max(0, -current);
    if (Number.isFinite(taken)) this._current = this._current === null ? taken : this._current + RENEWAL * (taken - this._current);
    chip.dataset.low = String(percentage < LOW);
    setText(byId("battery-text"), chargeText(percentage, runtime(charge, this._current)));
  }
}

/** How long a charge (A h) lasts (min) at a current (A); null: nobody knows. @param {number} charge @param {number | null} current */
export function runtime(charge, current) {
  return current === null || !(current > 0) || !Number.isFinite(charge) ? null : (60 * charge) / current;
}

/** @param {number} share @param {number | null} minutes */
export function chargeText(share, minutes) {
  // What is left is not rounded up to what it has not got.
  const percent = `${Math.floor(100 * share + 1e-6)} %`;
  if (share <= 0) return "EMPTY";
  if (minutes === null) return percent;
  const whole = Math.floor(minutes);
  return `${percent} · ${whole < 60 ? `${whole} min` : `${Math.floor(whole / 60)} h ${whole % 60} min`}`;
}
