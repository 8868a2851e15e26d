// @ts-check
/** Which alarm sounds now: one at a time, the gravest first, none for ever. */

import { lengthOf } from "./patterns.js";

/** @typedef {import("./patterns.js").Alarm} Alarm */

/** Time (s) for which something has to be over before it is a new alarm: what flickers is one. */
const OVER_AFTER = 5;

/** Between two alarms (s). */
const PAUSE = 0.4;

/** Room for the words of an alarm (s). */
const WORDS = 1.6;

/**
 * @typedef {object} State  Of an alarm; times in s.
 * @property {boolean} on
 * @property {number} ended   When it was seen to be on last.
 * @property {number} sounded  How often since it began.
 * @property {number} due     When it sounds next.
 * @property {boolean} acknowledged
 */

export class Alarms {
  /** @param {Alarm[]} table  The gravest first. */
  constructor(table) {
    this._table = table;
    /** @type {Map<string, State>} */
    this._states = new Map(table.map(({ name }) => [name, { on: false, ended: -Infinity, sounded: 0, due: 0, acknowledged: false }]));
    /** What sounds, and until when. @type {{rank: number, until: number}} */
    this._sounding = { rank: Infinity, until: -Infinity };
  }

  /** Names of what is on and neither acknowledged nor told as often as it is told. */
  get pending() {
    return this._table.filter((alarm) => this._isPending(alarm)).map(({ name }) => name);
  }

  /**
   * Take what is wrong now.
   * @param {Iterable<string>} names  Of alarms; what is not named is right again.
   * @param {number} now  s
   */
  see(names, now) {
    const wrong = new Set(names);
    for (const [name, state] of this._states) {
      if (wrong.has(name)) {
        if (!state.on && now - state.ended > OVER_AFTER) Object.assign(state, { sounded: 0, due: now, acknowledged: false });
        state.ended = now;
      }
      state.on = wrong.has(name);
    }
  }

  /** Whoever heard them all wants to hear no more of them, until one begins anew. */
  acknowledge() {
    for (const state of this._states.values()) if (state.on) state.acknowledged = true;
    this._sounding = { rank: Infinity, until: -Infinity };
  }

  /**
   * The alarm that begins to sound now, in place of a lesser one that sounds; null: none begins.
   * @param {number} now  s
   * @returns {{alarm: Alarm, isFirst: boolean} | null}  `isFirst`: of its times.
   */
  next(now) {
    const rank = this._table.findIndex((alarm) => this._isPending(alarm) && this._state(alarm).due <= now);
    if (rank < 0) return null;
    if (now < this._sounding.until && rank >= this._sounding.rank) return null;
    const alarm = this._table[rank], state = this._state(alarm);
    const isFirst = state.sounded === 0;
    state.sounded += 1;
    state.due = now + alarm.every;
    this._sounding = { rank, until: now + lengthOf(alarm) + (isFirst ? WORDS : PAUSE) };
    return { alarm, isFirst };
  }

  /** Whether an alarm sounds, or is told in words. @param {string} name @param {number} now  s */
  sounds(name, now) {
    return now < this._sounding.until && this._table[this._sounding.rank]?.name === name;
  }

  /** @param {Alarm} alarm */
  _state({ name }) {
    return /** @type {State} */ (this._states.get(name));
  }

  /** @param {Alarm} alarm */
  _isPending(alarm) {
    const { on, acknowledged, sounded } = this._state(alarm);
    return on && !acknowledged && sounded < alarm.times;
  }
}
