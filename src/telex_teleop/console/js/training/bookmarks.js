// @ts-check
/** Bookmarks on the strip, in practice: set them at any time, and go back to one. */

import { makeButton } from "../buttons.js";
import { language, text, translated } from "../language.js";
import { byId, element } from "../panels.js";

/** @typedef {import("./client.js").State} State */

export class StripBookmarks {
  /**
   * @param {HTMLElement} where  To be filled.
   * @param {import("./client.js").TrainingClient} client
   * @param {(reason: string) => void} letGo  Let go of all keys.
   */
  constructor(where, client, letGo) {
    this._where = where;
    this._client = client;
    this._letGo = letGo;
    /** Those that are offered, oldest first. @type {string[]} */
    this._names = [];
    this._listed = "";
    where.replaceChildren(
      made(makeButton(text("bookmark"), () => this.set()), "training-bookmark", text("Set a bookmark here, to go on from again")),
      made(makeButton(text("again from here"), () => this.back()), "training-back", text("Go back to the bookmark that is chosen; it counts for nothing")),
      made(element("select"), "training-bookmarks-names", text("Which bookmark")),
    );
    this._choice.setAttribute("aria-label", text("Bookmark"));
    // Keys must move the robot again.
    this._choice.addEventListener("change", () => this._choice.blur());
  }

  get _choice() {
    return /** @type {HTMLSelectElement} */ (byId("training-bookmarks-names"));
  }

  set() {
    this._client.act("bookmark", { name: "", replaces: "" });
  }

  /** Go back to the one that is chosen; the training node says why where there is none. */
  back() {
    // The robot is put back: held keys must not go on after it.
    this._letGo(text("back to a bookmark"));
    this._client.act("back", { name: this._choice.value });
  }

  /** @param {State} state */
  show(state) {
    const { canSet, names } = offered(state);
    byId("training-bookmark").hidden = !canSet;
    byId("training-back").hidden = this._choice.hidden = names.length === 0;
    this._where.hidden = !canSet && names.length === 0;
    const listed = JSON.stringify([names, language().code]);
    if (listed === this._listed) return; // a list that is open must stay
    const isNewest = this._choice.value === (this._names.at(-1) ?? "");
    const chosen = isNewest || !names.includes(this._choice.value) ? names.at(-1) ?? "" : this._choice.value;
    this._names = names;
    this._listed = listed;
    this._choice.replaceChildren(...names.slice().reverse().map((name) => new Option(translated(name), name)));
    this._choice.value = chosen;
  }
}

/**
 * Whether a bookmark can be set now, and which can be gone back to, oldest first.
 * @param {State} state
 * @returns {{canSet: boolean, names: string[]}}
 */
export function offered({ phase, mode, bookmarks }) {
  const canSet = mode === "practice" && ["waiting", "running"].includes(phase);
  return { canSet, names: mode === "practice" && (canSet || phase === "between") ? bookmarks : [] };
}

/** @param {HTMLElement} part @param {string} id @param {string} title */
const made = (part, id, title) => Object.assign(part, { id, title, hidden: true });
