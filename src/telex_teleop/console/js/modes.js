// @ts-check
/** What the operator's keys control: the arm in one of its modes, the tracks, or the camera. */

import { onClick } from "./buttons.js";
import { text } from "./language.js";
import { all, byId, check, setText } from "./panels.js";

/** @typedef {import("./vocabulary.js").Mode} Mode */

export class ModeSwitch {
  /**
   * @param {{name: Mode, note: string}[]} modes  What the keys are about in each.
   * @param {import("./tool.js").ToolPanel} tool
   * @param {(reason: string) => void} letGo
   * @param {import("./layouts.js").Layouts} layouts  Of which each mode has one.
   */
  constructor(modes, tool, letGo, layouts) {
    this._modes = modes;
    this._tool = tool;
    this._letGo = letGo;
    this._layouts = layouts;
    /** Instead of the arm's mode. @type {"DRIVE" | "CAMERA" | null} */
    this._own = ownMode(layouts.firstMode);
  }

  /** @returns {Mode} */
  get mode() {
    return this._own ?? this._tool.mode;
  }

  /** @param {Mode} mode */
  set(mode) {
    this._own = ownMode(mode);
    if (mode === "DRIVE" || mode === "CAMERA") this._letGo(text("{mode} mode", { mode: text(mode) }));
    // The arm is asked even where the page already shows its mode: only the arm knows it.
    else this._tool.setMode(mode);
    this.show();
  }

  /** Change to the arm's other mode, or back to the arm from tracks or camera. */
  toggle() {
    const other = this._tool.mode === "JOINT" && this._modes.some(({ name }) => name === "CARTESIAN") ? "CARTESIAN" : "JOINT";
    this.set(this._own === null ? other : this._tool.mode);
  }

  /** To the mode after the present one. */
  next() {
    const present = this._modes.findIndex(({ name }) => name === this.mode);
    this.set(this._modes[(present + 1) % this._modes.length].name);
  }

  show() {
    const { mode } = this;
    document.body.dataset.keysMode = mode;
    this._layouts.show(mode);
    check(all("[data-mode]"), ({ dataset }) => dataset.mode === mode);
    setText(byId("mode-note"), text(this._modes.find(({ name }) => name === mode)?.note ?? ""));
  }

  /** Let modes be chosen by clicks. @param {(command: string) => string} keyOf  Name of the action of a command. */
  listen(keyOf) {
    // The arm stays in the mode that it has.
    this._layouts.addTabs((modes) => this.set(modes.includes(this._tool.mode) ? this._tool.mode : modes[0]), keyOf);
    for (const { name: mode } of this._modes) {
      for (const button of all(`button[data-mode="${mode}"]`)) onClick(button, () => this.set(mode));
    }
  }
}

/** A mode that is the page's own, not the arm's. @param {Mode} mode */
const ownMode = (mode) => (mode === "DRIVE" || mode === "CAMERA" ? mode : null);
