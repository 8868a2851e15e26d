// @ts-check
/** The dosimeter's read-out over the picture: rates of hull and tool, total, alarm. */

import { text } from "../language.js";
import { byId, setText } from "../panels.js";
import { doseText, rateText } from "./units.js";

export const DOSIMETER = { topic: "dosimeter", type: "telex_msgs/Dosimeter" };

/** Time (ms) without a word after which there is no dosimeter: it speaks five times a second of sim time. */
const SILENT_AFTER = 2500;

/** @typedef {{hull_rate: number, tool_rate: number | null, detector: string, total: number, alarm: boolean}} Reading  telex_msgs/Dosimeter. */

export class DosimeterView {
  /** @param {(sentence: string) => void} warn  Told when the alarm begins. */
  constructor(warn) {
    this._warn = warn;
    this._heard = -Infinity;
    /** Whether a rate or the total is above what it warns of. */
    this.alarm = false;
  }

  /** @param {Reading} reading */
  set(reading) {
    this._heard = performance.now();
    const { hull_rate: hull, tool_rate: tool, total, alarm } = reading;
    const rates = [text("hull {rate}", { rate: rateText(hull) }), ...(tool === null ? [] : [text("tool {rate}", { rate: rateText(tool) })])].join("  ");
    setText(byId("dose-rate"), rates);
    setText(byId("dose-total"), `${doseText(total)}${alarm ? `  ${text("DOSE ALARM")}` : ""}`);
    if (alarm && !this.alarm) this._warn(text("dose alarm: {rates}, total {dose}", { rates, dose: doseText(total) }));
    this.alarm = alarm;
    byId("values").dataset.dose = alarm ? "alarm" : "measured";
  }

  /**
   * Show nothing where no dosimeter speaks any more; while the simulation is paused it has nothing to say.
   * @param {boolean} paused
   */
  fade(paused) {
    if (!paused && performance.now() - this._heard > SILENT_AFTER) this.forget();
  }

  /** Show nothing until it speaks. */
  forget() {
    this._heard = -Infinity;
    this.alarm = false;
    delete byId("values").dataset.dose;
  }
}
