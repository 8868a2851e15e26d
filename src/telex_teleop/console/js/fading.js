// @ts-check
/** Figures that are shown no longer than somebody tells them. */

import { byId, setText } from "./panels.js";

const SHOWN_FOR = 1000; // ms

export class FadingTexts {
  constructor() {
    /** When each was told last, by the id of its element. @type {Map<string, number>} */
    this._told = new Map();
  }

  /**
   * @param {string} id
   * @param {string} text
   */
  show(id, text) {
    this._told.set(id, performance.now());
    setText(byId(id), text);
  }

  /** Take away what is old. Call it every now and then. */
  fade() {
    const due = performance.now() - SHOWN_FOR;
    for (const [id, at] of this._told) if (at < due) setText(byId(id), "–");
  }
}
