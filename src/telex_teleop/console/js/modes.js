// @ts-check
/** What the operator's keys are about: the mode of the arm, or the tracks or the camera alone. */

import { MODES } from "./keymap.js";
import { byId, setText } from "./panels.js";

/** @typedef {import("./keymap.js").Mode} Mode */

const EXPLAINED = /** @type {Record<Mode, string>} */ ({
  DRIVE: "The arm's keys are off",
  JOINT: "Each joint by its pair of keys",
  CARTESIAN: "The tool moves straight and turns in place",
  CAMERA: "The arm's keys move the turret's camera",
});

export class ModeSwitch {
  /**
   * @param {import("./tool.js").ToolPanel} tool
   * @param {(reason: string) => void} letGo
   */
  constructor(tool, letGo) {
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
    this.set(MODES[(MODES.indexOf(this.mode) + 1) % MODES.length]);
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
    setText(byId("mode-note"), EXPLAINED[mode]);
  }

  /** @param {(button: HTMLElement, act: () => void) => void} onClick */
  listen(onClick) {
    for (const mode of MODES) {
      for (const button of /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll(`button[data-mode="${mode}"]`))) {
        onClick(button, () => this.set(mode));
      }
    }
  }
}
