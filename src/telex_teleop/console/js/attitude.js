// @ts-check
/** How the robot stands and how far it is from tipping over, over the picture. */

import { byId, setText } from "./panels.js";

export const STABILITY = { topic: "sim/stability", type: "telex_msgs/Stability" };

/** Time (ms) without a word after which the display shows nothing any more. */
const SILENT_AFTER = 1000;

/** By telex_msgs/Stability.state. */
const STATES = [
  { name: "stable", word: "stable" },
  { name: "caution", word: "CAUTION" },
  { name: "critical", word: "TIPPING" },
  { name: "tipped", word: "TIPPED OVER" },
];

/** Counter-clockwise from the nose, an eighth of a turn each. */
const WAYS = ["front", "front left", "left", "rear left", "rear", "rear right", "right", "front right"];

export class AttitudeView {
  constructor() {
    this._heard = -Infinity;
    this._show("silent");
  }

  /** @param {any} stability  telex_msgs/Stability */
  set(stability) {
    this._heard = performance.now();
    const { name, word } = STATES[stability.state] ?? STATES[0];
    const percent = Math.max(0, Math.round(100 * (stability.margin ?? 0)));
    const way = WAYS[Math.round((4 * (stability.direction ?? 0)) / Math.PI + 8) % 8];
    const pitch = describe(stability.pitch, "nose down", "nose up");
    const roll = describe(stability.roll, "right down", "left down");
    turn("attitude-side", stability.pitch);
    turn("attitude-rear", stability.roll);
    setText(byId("attitude-pitch"), pitch);
    setText(byId("attitude-roll"), roll);
    byId("attitude-fill").style.width = `${Math.min(100, percent)}%`;
    setText(byId("attitude-margin"), `${percent} %`);
    setText(byId("attitude-way"), percent > 0 && name !== "stable" && name !== "tipped" ? `over the ${way}` : "");
    const meter = byId("attitude-meter");
    meter.setAttribute("aria-valuenow", String(Math.min(100, percent)));
    meter.setAttribute("aria-valuetext", `${percent} percent, weakest over the ${way}`);
    this._show(name, word);
    byId("attitude-views").setAttribute("aria-label", `Attitude: ${pitch}, ${roll}`);
  }

  /** Show nothing rather than what was true a while ago. */
  fade() {
    if (performance.now() - this._heard > SILENT_AFTER) this._show("silent");
  }

  /**
   * @param {string} name
   * @param {string} [word]
   */
  _show(name, word = "") {
    const panel = byId("attitude");
    if (panel.dataset.state === name) return;
    panel.dataset.state = name;
    panel.hidden = name === "silent";
    setText(byId("attitude-word"), word);
  }
}

/**
 * @param {number | null} angle  rad; null is what the bridge makes of a figure that is none
 * @param {string} positive
 * @param {string} negative
 */
function describe(angle, positive, negative) {
  const degrees = Math.round(((angle ?? 0) * 180) / Math.PI);
  if (degrees === 0) return "level";
  return `${Math.abs(degrees)}° ${degrees > 0 ? positive : negative}`;
}

/**
 * @param {string} id
 * @param {number | null} angle  rad, clockwise
 */
function turn(id, angle) {
  byId(id).setAttribute("transform", `rotate(${(((angle ?? 0) * 180) / Math.PI).toFixed(1)})`);
}
