// @ts-check
/** The page's layouts, one for each task: two large views in each, chosen by the operator and kept in this browser for this robot. */

import { makeButton } from "./buttons.js";
import { text } from "./language.js";
import { all, byId, check, keyCap } from "./panels.js";
import { showAction, viewActions } from "./presence.js";

/** @typedef {import("./vocabulary.js").Mode} Mode */
/** @typedef {import("./vocabulary.js").Layout} Layout */
/** @typedef {{views: string[], second: boolean, small: boolean}} Kept  Cameras of the large views; whether the others are shown. */

/** Commands that lead to modes; one leads to those of the arm. @type {Record<string, string>} */
const LEAD_TO = { DRIVE: "drive mode", CAMERA: "camera mode" };

export class Layouts {
  /**
   * @param {import("./storage.js").Keeper} storage
   * @param {string} robot  Its namespace.
   * @param {Layout[]} layouts
   * @param {string} asked  Name of the one to begin with; what was there last where it is none.
   * @param {import("./cameras.js").Cameras} cameras
   * @param {import("./vocabulary.js").Action[]} actions  Those about views are shown where there are cameras enough.
   */
  constructor(storage, robot, layouts, asked, cameras, actions) {
    this._actions = actions;
    this._storage = storage;
    this._storedAs = `telex.layouts${robot}`;
    this._layouts = layouts;
    this._cameras = cameras;
    const { last = "", kept = {} } = this._load();
    /** By the layout's name. @type {Record<string, Kept | undefined>} */
    this._kept = kept;
    this._layout = layouts.find(({ name }) => name === (asked || last)) ?? layouts[0];
    cameras.chosen = () => this._change({ views: cameras.order.slice(0, 2) });
    /** Called when the page is laid out anew, or shows something else. */
    this.changed = () => {};
  }

  /** The one that is shown. */
  get present() {
    return this._layout;
  }

  /** In which mode the page begins. */
  get firstMode() {
    return this._layout.modes[0];
  }

  /**
   * Tabs that lead to the layouts.
   * @param {(modes: Mode[]) => void} choose
   * @param {(command: string) => string} keyOf  Name of the action of a command.
   */
  addTabs(choose, keyOf) {
    // With a single layout there is nothing to choose.
    byId("layouts").hidden = this._layouts.length < 2;
    byId("layouts").append(...this._layouts.map(({ name, modes }) => {
      const tab = makeButton("", () => choose(modes), "tab");
      tab.setAttribute("role", "radio");
      tab.dataset.layout = name;
      tab.append(keyCap(keyOf(LEAD_TO[modes[0]] ?? "mode")), text(name));
      return tab;
    }));
    this._show();
  }

  /** Show the layout of a mode. @param {Mode} mode */
  show(mode) {
    this._layout = this._layouts.find(({ modes }) => modes.includes(mode)) ?? this._layout;
    this._show();
    this._save();
  }

  _show() {
    const { views, second, small } = this._now;
    this._cameras.arrange(views);
    const count = this._cameras.order.length;
    for (const [name, isThere] of viewActions(this._actions, count)) showAction(document, name, isThere);
    const { dataset } = document.body;
    dataset.second = String(second && count > 1);
    dataset.small = String(small);
    check(all("[data-layout]"), (tab) => tab.dataset.layout === this._layout.name);
    byId("show-second").setAttribute("aria-pressed", String(second));
    byId("show-small").setAttribute("aria-pressed", String(small));
    this.changed();
  }

  /** @param {"second" | "small"} what */
  toggle(what) {
    this._change({ [what]: !this._now[what] });
    this._show();
  }

  /** Change the places of the two large views. */
  swap() {
    if (!this._now.second) this.toggle("second");
    else this._cameras.choose(this._cameras.order[1]);
  }

  /** Show another camera in the second view. */
  next() {
    if (!this._now.second) this.toggle("second");
    else this._cameras.next(1);
  }

  /** What is kept of the present layout, or else what it begins with. @returns {Kept} */
  get _now() {
    const there = this._cameras.order;
    const { name, first, second } = this._layout;
    const begin = first.find((camera) => there.includes(camera)) ?? this._cameras.preferred;
    const beside = second.find((camera) => there.includes(camera) && camera !== begin);
    return { views: [begin, ...(beside === undefined ? [] : [beside])], second: true, small: true, ...this._kept[name] };
  }

  /** @param {Partial<Kept>} changes */
  _change(changes) {
    this._kept[this._layout.name] = { ...this._now, ...changes };
    this._save();
    this.changed();
  }

  /** @returns {{last?: string, kept?: Record<string, Kept>}} */
  _load() {
    try {
      const { last, kept } = JSON.parse(this._storage.getItem(this._storedAs) ?? "{}");
      const isKept = (/** @type {any} */ each) =>
        Array.isArray(each?.views) && [each.second, each.small].every((shown) => typeof shown === "boolean");
      return { last: String(last), kept: Object.fromEntries(Object.entries(kept ?? {}).filter(([, each]) => isKept(each))) };
    } catch {
      return {}; // what another version or another program left there
    }
  }

  _save() {
    this._storage.setItem(this._storedAs, JSON.stringify({ last: this._layout.name, kept: this._kept }));
  }
}
