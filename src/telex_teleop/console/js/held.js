// @ts-check
/** Which actions are being held, by whatever: a key, a pointer on a button, a stick. */

import { stoodStill } from "./deadman.js";

export class Held {
  /** @param {() => void} changed  Called after every change. */
  constructor(changed) {
    this._changed = changed;
    /**
     * Who holds what, and how far: by source ("key:KeyW", "pointer:1", "pad:0:-1").
     * @type {Map<string, {name: string, amount: number}>}
     */
    this._holds = new Map();
  }

  /** What each source holds: names of actions. */
  get sources() {
    return [...this._holds].map(([source, { name }]) => ({ source, name }));
  }

  /** Names of the actions that are held. */
  get actions() {
    return new Set(this.amounts.keys());
  }

  /** How far each action is held, 0 to 1: the most of those who hold it. */
  get amounts() {
    /** @type {Map<string, number>} */
    const amounts = new Map();
    for (const { name, amount } of this._holds.values()) amounts.set(name, Math.max(amount, amounts.get(name) ?? 0));
    return amounts;
  }

  get empty() {
    return this._holds.size === 0;
  }

  /**
   * @param {string} source
   * @param {string} name  Of the action.
   * @param {number} [amount]  0 to 1
   */
  press(source, name, amount = 1) {
    // The first event after a standstill must not continue what was held before it.
    if (stoodStill()) {
      this.releaseAll();
      return;
    }
    const before = this._holds.get(source);
    this._holds.set(source, { name, amount });
    // A stick that moves further is sent with the next command; only a new action is sent at once.
    if (before?.name !== name) this._changed();
  }

  /** @param {string} source */
  release(source) {
    if (stoodStill()) this.releaseAll();
    else if (this._holds.delete(source)) this._changed();
  }

  /** Let go of everything; whatever is still pressed has to be pressed anew. */
  releaseAll() {
    this._holds.clear();
    this._changed();
  }
}
