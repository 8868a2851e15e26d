// @ts-check
/** Which key does what in which mode, as the user has it. Keys are positions (KeyboardEvent.code), whatever is printed on them. */

/** @typedef {import("./vocabulary.js").Mode} Mode */

const STORED_AS = "telex.keys";

export class KeyMap {
  /**
   * @param {import("./storage.js").Keeper} storage
   * @param {import("./vocabulary.js").Vocabulary} vocabulary  Its actions with a key can get another one.
   */
  constructor(storage, vocabulary) {
    this._storage = storage;
    this._actions = vocabulary.all.filter(({ code }) => code !== null);
    /** @type {Record<string, Mode[]>} */
    this._modes = Object.fromEntries(this._actions.map(({ name, modes }) => [name, modes]));
    /** @type {Record<string, string>} */
    this._defaults = Object.fromEntries(this._actions.map(({ name, code }) => [name, /** @type {string} */ (code)]));
    /** Further keys, which are not to be edited. @type {Record<string, string>} */
    this._more = Object.fromEntries(vocabulary.all.flatMap(({ name, more_codes }) => more_codes.map((code) => [code, name])));
    this._codes = { ...this._defaults, ...this._load() };
    /** Called after every change. */
    this.changed = () => {};
  }

  get names() {
    return Object.keys(this._defaults);
  }

  /** @param {string} name  @returns {string | undefined} */
  codeOf(name) {
    return this._codes[name];
  }

  /**
   * What a key is called where the browser does not know the user's layout.
   * @param {string} code
   */
  capOf(code) {
    const known = this._actions.find((action) => action.code === code);
    return known?.cap ?? code.replace(/^(Key|Digit)/, "").replace(/^Arrow/, "");
  }

  /**
   * What a key does.
   * @param {string} code
   * @param {Mode} mode
   * @returns {string | undefined} Name of an action.
   */
  find(code, mode) {
    const theirs = this.names.filter((name) => this._codes[name] === code);
    // A further key that the user has given to something is no further key any more.
    return theirs.length === 0 ? this._more[code] : theirs.find((name) => this._modes[name].includes(mode));
  }

  /**
   * Give something another key; what had that key gets the old one. Where that has another meaning in one of its modes, nothing changes.
   * @param {string} name
   * @param {string} code
   * @returns {{swapped: string[], obstacle?: {other: string, has: string}}} Names of what got the old key; or of what would have got
   *   it, and of what has it there.
   */
  set(name, code) {
    const before = this._codes[name];
    const swapped = this._rivals(name, code);
    for (const other of swapped) {
      const has = this._rivals(other, before).find((each) => each !== name);
      if (has !== undefined) return { swapped: [], obstacle: { other, has } };
    }
    for (const other of swapped) this._codes[other] = before;
    this._codes[name] = code;
    this._save();
    return { swapped };
  }

  /**
   * What else has a key in one of something's modes.
   * @param {string} name
   * @param {string} code
   */
  _rivals(name, code) {
    const meets = (/** @type {string} */ other) => this._modes[other].some((mode) => this._modes[name].includes(mode));
    return this.names.filter((each) => each !== name && this._codes[each] === code && meets(each));
  }

  reset() {
    this._codes = { ...this._defaults };
    this._save();
  }

  /** @returns {Record<string, string>} */
  _load() {
    try {
      const stored = JSON.parse(this._storage.getItem(STORED_AS) ?? "{}");
      return Object.fromEntries(
        Object.entries(stored).filter(([name, code]) => name in this._defaults && typeof code === "string"),
      );
    } catch {
      return {}; // what another version or another program left there is no key map
    }
  }

  _save() {
    const own = Object.entries(this._codes).filter(([name, code]) => code !== this._defaults[name]);
    this._storage.setItem(STORED_AS, JSON.stringify(Object.fromEntries(own)));
    this.changed();
  }
}
