// @ts-check
/** The list of all keys, in which each can be changed. */

import { makeButton } from "./buttons.js";
import { text, translated } from "./language.js";
import { all, byId, element, keyCap } from "./panels.js";

export class KeyDialog {
  /**
   * @param {import("./vocabulary.js").Vocabulary} vocabulary
   * @param {import("./keymap.js").KeyMap} keymap
   * @param {() => void} relabel  Shows the keys on the page anew.
   */
  constructor(vocabulary, keymap, relabel) {
    this._vocabulary = vocabulary;
    this._keymap = keymap;
    this._relabel = relabel;
    /** What waits for its new key. @type {string | null} */
    this._waiting = null;
    this._dialog = byId("keys");
    /** @type {Map<string, HTMLElement>} */
    const groups = new Map();
    for (const action of vocabulary.all) {
      if (action.code === null) continue;
      const group = groups.get(action.group) ?? element("section");
      if (!groups.has(action.group)) group.append(element("h3", "", text(action.group)));
      groups.set(action.group, group);
      group.append(this._line(action));
    }
    byId("key-groups").append(...groups.values());
    byId("keys-reset").addEventListener("click", () => {
      this._keymap.reset();
      this._tell(text("All keys are as they were at first."));
    });
    byId("keys-close").addEventListener("click", () => this.toggle());
  }

  get isOpen() {
    return !this._dialog.hidden;
  }

  toggle() {
    this._dialog.hidden = !this._dialog.hidden;
    this._wait(null);
    this._tell("");
    this._relabel();
  }

  /**
   * Take a key that was pressed while the list is open.
   * @param {string} code
   * @returns {boolean} Whether the key was meant for the list.
   */
  take(code) {
    if (!this.isOpen) return false;
    const name = this._waiting;
    if (name === null) return false;
    if (code.startsWith("Shift")) return true; // on its way to another key
    this._wait(null);
    if (code === this._keymap.codeOf(this._vocabulary.emergencyStop)) {
      this._tell(text("{key} is the e-stop, always.", { key: translated(this._keymap.capOf(code)) }));
      return false;
    }
    const title = (/** @type {string} */ each) => text(this._vocabulary.get(each)?.title ?? each);
    const { swapped, obstacle } = this._keymap.set(name, code);
    if (obstacle !== undefined) {
      this._tell(text("Nothing was changed: “{action}” would get the old key, which “{other}” has.", { action: title(obstacle.other), other: title(obstacle.has) }));
    } else {
      this._tell(swapped.length > 0 ? text("{action} has the old key now.", { action: swapped.map(title).join(", ") }) : "");
    }
    return true;
  }

  /** @param {import("./vocabulary.js").Action} action */
  _line({ name, title }) {
    const line = makeButton("", () => {
      this._wait(name);
      this._tell(text("Press the new key for “{action}”.", { action: text(title) }));
    }, "key-line");
    line.dataset.key = name;
    line.append(keyCap(name), element("span", "", text(title)));
    line.disabled = name === this._vocabulary.emergencyStop;
    return line;
  }

  /** @param {string | null} name */
  _wait(name) {
    this._waiting = name;
    for (const line of all("[data-key]", this._dialog)) {
      line.classList.toggle("waiting", line.dataset.key === name);
    }
  }

  /** @param {string} sentence */
  _tell(sentence) {
    byId("keys-note").textContent = sentence || text("Click a line, then press its new key. Keys count by their place on the keyboard.");
  }
}
