// @ts-check
/** The line between console and robot as the bridge reports it: delay, signal, and outages. */

import { decimal, text, translated } from "./language.js";

export const LINK_STATE = { topic: "link/state", type: "telex_msgs/LinkState" };

/** Least signal (0 to 1) with which it is good, and fair. */
const SIGNAL = { good: 0.6, fair: 0.3 };

/** @typedef {"good" | "fair" | "poor" | "lost"} Quality */

/**
 * @typedef {object} LinkState  telex_msgs/LinkState
 * @property {string} profile
 * @property {boolean} perfect
 * @property {number} delay      s, one way.
 * @property {number} jitter     s.
 * @property {number} loss       Share.
 * @property {number} bandwidth  bit/s.
 * @property {boolean} outage
 * @property {boolean} signal_known
 * @property {number} signal     0 to 1.
 */

export class Line {
  /** @param {(sentence: string, level: import("./messages.js").Level) => void} log */
  constructor(log) {
    this._log = log;
    /** @type {LinkState | null} */
    this._state = null;
  }

  /** Whether something is impaired, as far as the bridge has said. */
  get impaired() {
    return this._state !== null && !this._state.perfect;
  }

  /** By how much (ms) it delays what comes over it, at most, as far as the bridge has said. */
  get delay() {
    return this._state === null ? 0 : 1000 * (this._state.delay + this._state.jitter);
  }

  /** @param {LinkState} state */
  hear(state) {
    const before = this._state;
    this._state = state;
    // An operator behind the line learns of an outage when it is over; an instructor at once.
    if (state.outage && !before?.outage) this._log(text("the line is down"), "warning");
    if (!state.outage && before?.outage) this._log(text("the line is up again"), "info");
    const name = (/** @type {LinkState | null} */ each) => (each === null ? "perfect" : each.profile);
    if (name(before) !== name(state)) this._log(text("line: {profile}", { profile: translated(state.profile) }), "info");
  }

  /** Quality of the radio signal; null where none is known. @returns {Quality | null} */
  get quality() {
    if (this._state === null || !this._state.signal_known) return null;
    const { signal, outage } = this._state;
    if (outage) return "lost";
    return signal >= SIGNAL.good ? "good" : signal >= SIGNAL.fair ? "fair" : "poor";
  }

  /** The signal, 0 to 1; null where none is known. */
  get signal() {
    return this._state?.signal_known === true ? this._state.signal : null;
  }

  /** What to say of the line beside its quality; empty where nothing is impaired. */
  get text() {
    if (this._state === null || this._state.perfect) return "";
    const { outage, delay, jitter, signal_known: isKnown, signal } = this._state;
    const late = text("{delay} ms each way", { delay: `${Math.round(1000 * delay)}${jitter > 0 ? `–${Math.round(1000 * (delay + jitter))}` : ""}` });
    return [outage ? text("DOWN") : late, isKnown ? text("signal {percent} %", { percent: Math.round(100 * signal) }) : ""].filter(Boolean).join(", ");
  }

  /**
   * What to say while nothing comes from the robot.
   * @param {number} silence  ms.
   */
  silent(silence) {
    const since = `${decimal(silence / 1000, 1)} s`;
    return this.impaired
      ? text("The line is down: nothing has come from the robot for {since}. Everything is released.", { since })
      : text("The robot does not answer. Everything is released.");
  }
}
