// @ts-check
/** Which key does what in which mode, as the user has it. Keys are positions (KeyboardEvent.code), whatever is printed on them. */

import { ACTIONS, COMMANDS } from "./robot.js";

/** @typedef {"DRIVE" | "JOINT" | "CARTESIAN" | "CAMERA"} Mode */

/** @type {Mode[]} */
export const MODES = ["DRIVE", "JOINT", "CARTESIAN", "CAMERA"];

const STORED_AS = "telex.keys";

/** Second keys of the number pad, which are not to be edited. @type {Record<string, string>} */
const ALIASES = { NumpadSubtract: "slower", NumpadAdd: "faster", NumpadEnter: "camera_mode" };

/**
 * Modes in which an action has its key.
 * @param {string} name  Of an action or a command.
 * @returns {Mode[]}
 */
export function modesOf(name) {
  const action = ACTIONS[name];
  if (action === undefined) return MODES;
  if (name.startsWith("camera_")) return ["CAMERA"];
  if (action.kind === "tool") return ["CARTESIAN"];
  if (action.kind === "pose") return ["JOINT", "CARTESIAN"];
  if (action.kind === "joints" && action.node === "arm_teleop" && !name.startsWith("look:")) return ["JOINT"];
  return MODES;
}

/**
 * What a key is called where the browser does not know the user's layout.
 * @param {string} code
 */
export function capOf(code) {
  const known = [...Object.values(ACTIONS), ...Object.values(COMMANDS)].find((each) => each.code === code);
  return known?.cap ?? code.replace(/^(Key|Digit)/, "").replace(/^Arrow/, "");
}

export class KeyMap {
  /** @param {Storage} storage */
  constructor(storage) {
    this._storage = storage;
    /** @type {Record<string, string>} */
    this._defaults = Object.fromEntries(
      [...Object.entries(ACTIONS), ...Object.entries(COMMANDS)].map(([name, { code }]) => [name, code]),
    );
    this._codes = { ...this._defaults, ...this._load() };
    /** Called after every change. */
    this.changed = () => {};
  }

  get names() {
    return Object.keys(this._defaults);
  }

  /** @param {string} name */
  codeOf(name) {
    return this._codes[name];
  }

  /**
   * What a key does.
   * @param {string} code
   * @param {Mode} mode
   * @returns {string | undefined} Name of an action or a command.
   */
  find(code, mode) {
    return ALIASES[code] ?? this.names.find((name) => this._codes[name] === code && modesOf(name).includes(mode));
  }

  /**
   * Give something another key; what had that key gets the old one.
   * @param {string} name
   * @param {string} code
   * @returns {string[]} Names of what got the old key.
   */
  set(name, code) {
    const before = this._codes[name];
    const modes = modesOf(name);
    const others = this.names.filter(
      (each) => each !== name && this._codes[each] === code && modesOf(each).some((mode) => modes.includes(mode)),
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
