// @ts-check
/** The gas sensor's read-out over the picture. */

import { byId, setText } from "./panels.js";

export const GAS = { topic: "gas", type: "telex_msgs/Gas" };

/** Time (ms) without a word after which there is no sensor: it speaks five times a second of sim time. */
const SILENT_AFTER = 2500;

export class GasView {
  constructor() {
    this._heard = -Infinity;
  }

  /** @param {{concentration: number | null}} reading  telex_msgs/Gas; the bridge makes null of what is no number. */
  set({ concentration }) {
    this._heard = performance.now();
    setText(byId("gas"), `${concentration?.toFixed(0) ?? "–"} ppm`);
    byId("values").dataset.gas = "measured";
  }

  /**
   * Show nothing where no sensor speaks any more; while the simulation is paused it has nothing to say.
   * @param {boolean} paused
   */
  fade(paused) {
    if (!paused && performance.now() - this._heard > SILENT_AFTER) this.forget();
  }

  /** Show nothing until it speaks. */
  forget() {
    this._heard = -Infinity;
    delete byId("values").dataset.gas;
  }
}
