// @ts-check
/** Which aids are on in each layout of the page, kept in this browser for this robot; and the menu that switches them. */

import { text, translated } from "../language.js";
import { byId, element } from "../panels.js";

/**
 * By its command in the vocabulary: the equipment without which an aid is one for training; one that `stays` shows something
 * without as well, also in an exam.
 * @type {Record<string, {needs?: string, stays?: boolean}>}
 */
const AIDS = {
  "guide lines": {},
  "aim line": { needs: "range_finder", stays: true },
  "finger gap": { needs: "range_finder", stays: true },
  "contact marks": { needs: "pads" },
  horizon: {},
  compass: {},
  "zoom factor": {},
  plan: {},
};

/** @typedef {{equipment: Record<string, any>, exam: boolean}} Allowed  What the robot has, and whether it is all that may be shown. */

export class Switches {
  /**
   * @param {import("../storage.js").Keeper} storage
   * @param {string} robot  Its namespace.
   * @param {import("../vocabulary.js").Vocabulary} vocabulary
   * @param {import("../layouts.js").Layouts} layouts  Whose present one counts.
   * @param {(sentence: string) => void} warn
   */
  constructor(storage, robot, vocabulary, layouts, warn) {
    this._storage = storage;
    this._storedAs = `telex.aids${robot}`;
    this._layouts = layouts;
    this._warn = warn;
    /** By the layout's name. @type {Record<string, string[]>} */
    this._kept = this._load();
    /** @type {Allowed} */
    this._allowed = { equipment: {}, exam: false };
    /** Called when another one is on. */
    this.changed = () => {};
    /** @type {{name: string, button: HTMLElement, note: HTMLElement}[]} */
    this._buttons = vocabulary.find("command").filter(({ does }) => does.name in AIDS).map(({ name: action, does, label }) => {
      const button = element("button", "small");
      button.setAttribute("type", "button");
      button.setAttribute("role", "checkbox");
      button.dataset.command = action;
      const cap = element("kbd");
      cap.dataset.binding = action;
      const note = element("span", "aid-note");
      button.append(cap, element("span", "", text(label)), note);
      return { name: does.name, button, note };
    });
    byId("aids-switches").append(...this._buttons.map(({ button }) => button));
    this.show();
  }

  /** How each of them is switched. @returns {Record<string, () => void>} */
  get commands() {
    return Object.fromEntries(Object.keys(AIDS).map((name) => [name, () => this.set(name, !this.isOn(name))]));
  }

  /** @returns {string[]}  What is on and may be shown. */
  get on() {
    return this._wanted.filter((name) => this._may(name));
  }

  /** @param {string} name */
  isOn(name) {
    return this.on.includes(name);
  }

  /** @param {string} name  Whether what it shows needs equipment that the robot lacks. */
  isTrainingAid(name) {
    const { needs } = AIDS[name];
    return needs !== undefined && !(needs in this._allowed.equipment);
  }

  get _wanted() {
    const { name, aids = [] } = this._layouts.present;
    return this._kept[name] ?? aids;
  }

  /** @param {string} name */
  _may(name) {
    return !this._allowed.exam || !this.isTrainingAid(name) || AIDS[name].stays === true;
  }

  /** What is on, as the telemetry says it: true for a training aid. @returns {Record<string, boolean>} */
  get told() {
    return Object.fromEntries(this.on.map((name) => [name, this.isTrainingAid(name)]));
  }

  /** @param {string} name @param {boolean} isOn */
  set(name, isOn) {
    if (isOn && !this._may(name)) {
      this._warn(text("not in an exam: this robot has no {equipment}", { equipment: translated((AIDS[name].needs ?? "").replace(/_/g, " ")) }));
      return;
    }
    const others = this._wanted.filter((each) => each !== name);
    this._kept[this._layouts.present.name] = isOn ? [...others, name] : others;
    this._save();
    this.show();
    this.changed();
  }

  /** @param {Allowed} allowed */
  allow(allowed) {
    this._allowed = allowed;
    this.show();
    this.changed();
  }

  toggleMenu() {
    const menu = byId("aids");
    menu.hidden = !menu.hidden;
    this.show();
  }

  /** Show in the menu what is on. */
  show() {
    byId("aids-open").setAttribute("aria-expanded", String(!byId("aids").hidden));
    for (const { name, button, note } of this._buttons) {
      const lacks = this.isTrainingAid(name);
      button.setAttribute("aria-checked", String(this.isOn(name)));
      /** @type {HTMLButtonElement} */ (button).disabled = !this._may(name);
      const said = !lacks ? "" : !this._allowed.exam ? text("◇ training aid") : this._may(name) ? "" : text("not in an exam");
      if (note.textContent !== said) note.textContent = said;
    }
  }

  /** @returns {Record<string, string[]>} */
  _load() {
    try {
      const kept = Object.entries(JSON.parse(this._storage.getItem(this._storedAs) ?? "{}"));
      const known = (/** @type {any} */ names) => names.filter((/** @type {any} */ name) => typeof name === "string" && name in AIDS);
      return Object.fromEntries(kept.filter(([, names]) => Array.isArray(names)).map(([layout, names]) => [layout, known(names)]));
    } catch {
      return {}; // what another version or another program left there
    }
  }

  _save() {
    this._storage.setItem(this._storedAs, JSON.stringify(this._kept));
  }
}
