// @ts-check
/** The instructor's bookmarks: of a trainee's practice where one goes on, else of the simulator. */

import { makeButton, onClick } from "../buttons.js";
import { text, translated } from "../language.js";
import { byId, element } from "../panels.js";
import { BEGUN } from "./client.js";

/** @typedef {import("./client.js").State} State */

const LONGEST = 60; // characters of a name

export class InstructorBookmarks {
  /**
   * @param {import("../robot_client.js").RobotClient} robot
   * @param {import("../robot_client.js").RobotClient} [first]  The first robot, whose exercises those for one robot are.
   */
  constructor(robot, first = robot) {
    this._robot = robot;
    this._first = first;
    /** The simulator's, oldest first. @type {string[]} */
    this._there = [];
    /** @type {State | null} */
    this._state = null;
    this._name = build();
    this._choice.addEventListener("pointerdown", () => this.list()); // others may have set some
    onClick(byId("bookmarks-set"), () => this._set());
    onClick(byId("bookmarks-back"), () => this._back());
    this._show();
  }

  get _choice() {
    return /** @type {HTMLSelectElement} */ (byId("bookmarks-names"));
  }

  /** Whose bookmarks these are now. */
  get _of() {
    return bookmarksOf(this._state);
  }

  /** Ask which the simulator has; after every new connection, and when a trial has ended. */
  async list() {
    try {
      this._there = (await this._robot.call("sim/list_bookmarks", {})).names;
    } catch {
      // Those that were there are shown until the next time.
    }
    this._show();
  }

  /** @param {State} state */
  show(state) {
    const before = this._of;
    this._state = state;
    if (this._of !== before) this.list();
    else this._show();
  }

  _show() {
    const of = this._of;
    const names = of === "practice" ? this._state?.bookmarks ?? [] : of === "simulator" ? this._there : [];
    const shown = [...this._choice.options].map(({ value }) => value).reverse();
    if (JSON.stringify(names) !== JSON.stringify(shown)) {
      const chosen = names.includes(this._choice.value) && this._choice.value !== shown.at(-1) ? this._choice.value : names.at(-1) ?? "";
      this._choice.replaceChildren(...names.slice().reverse().map((name) => new Option(translated(name), name)));
      this._choice.value = chosen;
    }
    const why = of === "exam" ? text("An exam has no bookmarks") : "";
    for (const [id, off] of /** @type {[string, boolean][]} */ ([
      ["bookmarks-set", of === "exam" || (of === "practice" && this._state?.phase === "between")],
      ["bookmarks-back", names.length === 0],
      ["bookmarks-names", names.length === 0],
    ])) {
      const part = /** @type {HTMLButtonElement | HTMLSelectElement} */ (byId(id));
      part.disabled = off;
      part.title = why;
    }
  }

  async _set() {
    const fields = { name: this._name.value.trim(), replaces: "" };
    const service = this._of === "practice" ? "training/bookmark" : "sim/bookmark";
    const answer = await this._call(service, fields);
    if (answer === null) return;
    this._name.value = "";
    this._robot.log(translated(answer.message));
    this.list();
  }

  async _back() {
    const service = this._of === "practice" ? "training/back" : "sim/restore";
    const answer = await this._call(service, { name: this._choice.value });
    if (answer !== null) this._robot.log(translated(answer.message));
    else this.list();
  }

  /**
   * @param {string} service
   * @param {object} fields
   */
  _call(service, fields) {
    const robot = service.startsWith("training/") ? this._first : this._robot;
    return robot.request(service, fields, (why) => `${service}: ${why}`);
  }
}

/**
 * Whose bookmarks are used: those of the simulator would bypass the training node and spoil a trial.
 * @param {State | null} state
 * @returns {"practice" | "exam" | "simulator"}
 */
export function bookmarksOf(state) {
  if (state === null || !BEGUN.includes(state.phase)) return "simulator";
  return state.mode === "exam" ? "exam" : "practice";
}

/** Fill the page's place for them. @returns {HTMLInputElement} The field of the name. */
function build() {
  const name = /** @type {HTMLInputElement} */ (element("input"));
  Object.assign(name, { id: "bookmarks-name", maxLength: LONGEST, autocomplete: "off", placeholder: text("name, or none") });
  name.setAttribute("aria-label", text("Name of the bookmark"));
  const choice = element("select");
  choice.id = "bookmarks-names";
  choice.setAttribute("aria-label", text("Bookmark to go back to"));
  const button = (/** @type {string} */ id, /** @type {string} */ words) => Object.assign(makeButton(words, undefined, "hold"), { id });
  byId("bookmarks").replaceChildren(name, button("bookmarks-set", text("bookmark")), choice, button("bookmarks-back", text("back to it")));
  return name;
}
