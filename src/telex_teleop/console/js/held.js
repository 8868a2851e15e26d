// @ts-check
/** Which actions are being held, by whatever: a key, a pointer on a button. */

export class Held {
  /** @param {() => void} changed  Called after every change. */
  constructor(changed) {
    this._changed = changed;
    /** Who holds what: source ("key:KeyW", "pointer:1") to name of the action. @type {Map<string, string>} */
    this._holds = new Map();
  }

  /** Names of the actions that are held. */
  get actions() {
    return new Set(this._holds.values());
  }

  get empty() {
    return this._holds.size === 0;
  }

  /**
   * @param {string} source
   * @param {string} action
   */
  press(source, action) {
    this._holds.set(source, action);
    this._changed();
  }

  /** @param {string} source */
  release(source) {
    if (this._holds.delete(source)) this._changed();
  }

  /** Let go of everything; whatever is still pressed has to be pressed anew. */
  releaseAll() {
    this._holds.clear();
    this._changed();
  }
}
