// @ts-check
/** What the operator's keys are about: the mode of the arm, or the tracks or the camera alone. */

import { byId, setText } from "./panels.js";

/** @typedef {import("./vocabulary.js").Mode} Mode */

export class ModeSwitch {
  /**
   * @param {{name: Mode, note: string}[]} modes  What the keys are about in each.
   * @param {import("./tool.js").ToolPanel} tool
   * @param {(reason: string) => void} letGo
   */
  constructor(modes, tool, letGo) {
    this._modes = modes;
    this._tool = tool;
    this._letGo = letGo;
    /** Called with the mode that an operator has chosen. @type {(mode: Mode) => void} */
    this.chosen = () => {};
    /** Instead of the arm's mode. @type {"DRIVE" | "CAMERA" | null} */
    this._own = null;
  }

  /** @returns {Mode} */
  get mode() {
    return this._own ?? this._tool.mode;
  }

  /** @param {Mode} mode */
  set(mode) {
    if (mode === "DRIVE" || mode === "CAMERA") {
      this._letGo(`${mode} mode`);
      this._own = mode;
    } else {
      this._own = null;
      // Even where the page shows this mode already the arm is asked: only it knows.
      this._tool.setMode(mode);
    }
    this.chosen(mode);
    this.show();
  }

  /** To the arm's other mode, or back to the arm from what is not about it. */
  toggle() {
    const other = this._tool.mode === "JOINT" ? "CARTESIAN" : "JOINT";
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
    for (const button of /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll("[data-mode]"))) {
      button.setAttribute("aria-checked", String(button.dataset.mode === mode));
    }
    byId("arm-rows").hidden = mode === "CARTESIAN" || mode === "CAMERA";
    byId("tool-rows").hidden = byId("tool-options").hidden = mode !== "CARTESIAN";
    byId("camera-rows").hidden = mode !== "CAMERA";
    byId("pose-buttons").hidden = mode === "CAMERA";
    setText(byId("arm-title"), mode === "CAMERA" ? "Camera" : "Arm");
    setText(byId("mode-note"), this._modes.find(({ name }) => name === mode)?.note ?? "");
  }

  /** @param {(button: HTMLElement, act: () => void) => void} onClick */
  listen(onClick) {
    for (const { name: mode } of this._modes) {
      for (const button of /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll(`button[data-mode="${mode}"]`))) {
        onClick(button, () => this.set(mode));
      }
    }
  }
}
