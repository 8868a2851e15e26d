// @ts-check
/** A guided tour at first use: each step ends when the operator has done it. It can be skipped, and stops nothing. */

import { byId } from "./panels.js";

const STORED_AS = "telex.tour";

/** @type {{text: string, done: RegExp, keys: string[], shows: string}[]} */
const STEPS = [
  { text: "Drive: hold the key, let go to stop.", done: /^drive:/, keys: ["drive:forward", "drive:left", "drive:back", "drive:right"], shows: "drive-pad" },
  { text: "Raise the front flippers, as before a step or stairs.", done: /^front:/, keys: ["front:up", "front:down"], shows: "flipper-rows" },
  { text: "Move a joint of the arm. Every joint has a pair of keys.", done: /^(shoulder|turret|elbow|telescope|forearm_roll|wrist_pitch|tool_)/, keys: ["shoulder:up", "shoulder:down"], shows: "arm-rows" },
  { text: "Close the gripper, and open it.", done: /^gripper:/, keys: ["gripper:close", "gripper:open"], shows: "gripper-rows" },
];

export class Tour {
  /** @param {Storage} storage  @param {() => void} relabel */
  constructor(storage, relabel) {
    this._storage = storage;
    this._relabel = relabel;
    this._step = -1;
    for (const id of ["tour-skip", "tour-next"]) {
      byId(id).addEventListener("pointerdown", (event) => event.preventDefault());
      byId(id).addEventListener("mousedown", (event) => event.preventDefault());
    }
    byId("tour-skip").addEventListener("click", () => this._end());
    byId("tour-next").addEventListener("click", () => this._go(this._step + 1));
    if (this._isNew()) this.start();
  }

  start() {
    this._go(0);
  }

  /** @param {Iterable<string>} actions  Names of those that are held. */
  see(actions) {
    const step = STEPS[this._step];
    if (step !== undefined && [...actions].some((name) => step.done.test(name))) this._go(this._step + 1);
  }

  /** @param {number} step */
  _go(step) {
    for (const { shows } of STEPS) byId(shows).classList.remove("toured");
    this._step = step;
    const { text = "", keys = [], shows = "" } = STEPS[step] ?? {};
    if (text === "") return this._end();
    byId("tour").hidden = false;
    byId("tour-count").textContent = `${step + 1} of ${STEPS.length}`;
    byId("tour-text").textContent = text;
    byId("tour-keys").replaceChildren(...keys.map((name) => {
      const cap = document.createElement("kbd");
      cap.dataset.binding = name;
      return cap;
    }));
    byId(shows).classList.add("toured");
    this._relabel();
  }

  _end() {
    for (const { shows } of STEPS) byId(shows).classList.remove("toured");
    this._step = -1;
    byId("tour").hidden = true;
    try {
      this._storage.setItem(STORED_AS, "seen");
    } catch {
      // A browser that stores nothing shows the tour every time.
    }
  }

  _isNew() {
    try {
      return this._storage.getItem(STORED_AS) === null;
    } catch {
      return true;
    }
  }
}
