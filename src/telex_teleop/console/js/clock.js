// @ts-check
/** The mission clock: runs from the first motion that is commanded; a click sets it to zero. */

import { byId, setText } from "./panels.js";

export class MissionClock {
  constructor() {
    /** @type {number | null} */
    this._since = null;
    this.show();
  }

  begin() {
    this._since ??= performance.now();
  }

  reset() {
    this._since = null;
    this.show();
  }

  show() {
    const seconds = this._since === null ? 0 : Math.floor((performance.now() - this._since) / 1000);
    const two = (/** @type {number} */ number) => String(number).padStart(2, "0");
    const hours = Math.floor(seconds / 3600);
    setText(byId("clock"), `${hours > 0 ? `${hours}:` : ""}${two(Math.floor(seconds / 60) % 60)}:${two(seconds % 60)}`);
  }
}
