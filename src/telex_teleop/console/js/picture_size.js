// @ts-check
/** Detects that the large view's pictures are smaller than its camera's own, as they are while the machine is overloaded. */

import { OVERVIEW } from "./overview.js";
import { getParameter } from "./parameters.js";

const SETTLED = 1000; // ms; a view that has just become large may still get a small picture

export class PictureSize {
  /**
   * @param {import("./bridge.js").Bridge} bridge
   * @param {(name: string) => string} topic
   */
  constructor(bridge, topic) {
    this._bridge = bridge;
    this._topic = topic;
    /** Of what is shown: camera and width. */
    this._shown = "";
    this._since = 0;
    /** Width (px) of the camera's own pictures; null: not known. @type {number | null} */
    this._own = null;
  }

  /** Whether pictures have been smaller for a while. @param {import("./cameras.js").ViewState} view */
  isReduced({ camera, width }) {
    const shown = `${camera} ${width}`;
    if (shown !== this._shown && this._bridge.connected) {
      this._shown = shown;
      this._since = performance.now();
      this._own = null;
      this._ask(camera, shown);
    }
    return width !== null && width < (this._own ?? 0) && performance.now() - this._since > SETTLED;
  }

  /**
   * @param {string} camera
   * @param {string} shown
   */
  async _ask(camera, shown) {
    try {
      const name = camera === OVERVIEW ? OVERVIEW : `cameras/${camera}`;
      const own = await getParameter(this._bridge, this._topic(`cameras/${name}/width`));
      if (shown === this._shown && Number.isFinite(own)) this._own = own;
    } catch {
      // Of a camera that does not tell, nothing is said.
    }
  }
}
