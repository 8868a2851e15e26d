// @ts-check
/** The list of all keys, in which each can be changed. */

import { CAMERA_ACTIONS, LAMPS, LOOK_ACTIONS } from "./camera_actions.js";
import { modesOf } from "./keymap.js";
import { byId, element } from "./panels.js";
import { ACTIONS, COMMANDS } from "./robot.js";
import { POSE_ACTIONS, TOOL_ACTIONS } from "./tool_actions.js";

/** @param {(name: string) => boolean} is  @param {string[]} names */
const pick = (is, names = Object.keys(ACTIONS)) => names.filter(is);

/** Titles and the names of what stands below. @type {[string, string[]][]} */
const GROUPS = [
  ["Always", Object.keys(COMMANDS).filter((name) => !(name in LAMPS))],
  ["Tracks and gripper", pick((name) => /^(drive|gripper):/.test(name))],
  ["Flippers", pick((name) => /^(front|rear|side|preset):/.test(name))],
  ["Arm, JOINT", pick((name) => modesOf(name).join() === "JOINT")],
  ["Arm, CARTESIAN", Object.keys(TOOL_ACTIONS)],
  ["Arm poses", Object.keys(POSE_ACTIONS)],
  ["Camera and lamps", [...Object.keys(LOOK_ACTIONS), ...Object.keys(LAMPS)]],
  ["CAMERA", Object.keys(CAMERA_ACTIONS)],
];

/** @param {string} name */
function describe(name) {
  if (name in COMMANDS) return COMMANDS[/** @type {keyof typeof COMMANDS} */ (name)].label;
  const [what] = name.split(":");
  const { label } = ACTIONS[name];
  if (["preset", "pose", "look", "side", "camera_zoom"].includes(what)) return what === "side" ? `${label} flippers only` : label;
  return `${what.replace(/^(tool|camera)_/, "").replace(/_/g, " ")} ${label}`;
}

export class KeyDialog {
  /**
   * @param {import("./keymap.js").KeyMap} keymap
   * @param {() => void} relabel  Shows the keys on the page anew.
   */
  constructor(keymap, relabel) {
    this._keymap = keymap;
    this._relabel = relabel;
    /** What waits for its new key. @type {string | null} */
    this._waiting = null;
    this._dialog = byId("keys");
    for (const [title, names] of GROUPS) {
      const group = element("section");
      group.append(element("h3", "", title), ...names.map((name) => this._line(name)));
      byId("key-groups").append(group);
    }
    byId("keys-reset").addEventListener("click", () => {
      this._keymap.reset();
      this._tell("All keys are as they were at first.");
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
    if (code === "Escape") {
      this._tell("Esc is the e-stop, always.");
      return false;
    }
    const others = this._keymap.set(name, code);
    this._tell(others.length > 0 ? `${others.map(describe).join(", ")} has the old key now.` : "");
    return true;
  }

  /** @param {string} name */
  _line(name) {
    const line = /** @type {HTMLButtonElement} */ (element("button", "key-line"));
    line.type = "button";
    line.tabIndex = -1;
    line.dataset.key = name;
    const cap = element("kbd");
    cap.dataset.binding = name;
    line.append(cap, element("span", "", describe(name)));
    line.disabled = name === "estop";
    line.addEventListener("pointerdown", (event) => event.preventDefault());
    line.addEventListener("mousedown", (event) => event.preventDefault());
    line.addEventListener("click", () => {
      this._wait(name);
      this._tell(`Press the new key for "${describe(name)}".`);
    });
    return line;
  }

  /** @param {string | null} name */
  _wait(name) {
    this._waiting = name;
    for (const line of /** @type {NodeListOf<HTMLElement>} */ (this._dialog.querySelectorAll("[data-key]"))) {
      line.classList.toggle("waiting", line.dataset.key === name);
    }
  }

  /** @param {string} sentence */
  _tell(sentence) {
    byId("keys-note").textContent = sentence || "Click a line, then press its new key. Keys count by their place on the keyboard.";
  }
}
