// @ts-check
/** Which key does what in which mode, as the user has it. Keys are positions (KeyboardEvent.code), whatever is printed on them. */

/** @typedef {import("./vocabulary.js").Mode} Mode */

const STORED_AS = "telex.keys";

export class KeyMap {
  /**
   * @param {Storage} storage
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
    return this._more[code] ?? this.names.find((name) => this._codes[name] === code && this._modes[name].includes(mode));
  }

  /**
   * Give something another key; what had that key gets the old one.
   * @param {string} name
   * @param {string} code
   * @returns {string[]} Names of what got the old key.
   */
  set(name, code) {
    const before = this._codes[name];
    const modes = this._modes[name];
    const others = this.names.filter(
      (each) => each !== name && this._codes[each] === code && this._modes[each].some((mode) => modes.includes(mode)),
    );
    for (const other of others) this._codes[other] = before;
    this._codes[name] = code;
    this._save();
    return others;
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
    try {
      this._storage.setItem(STORED_AS, JSON.stringify(Object.fromEntries(own)));
    } catch {
      // A browser that stores nothing has the keys until the page is closed.
    }
    this.changed();
  }
}
