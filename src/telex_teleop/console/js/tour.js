// @ts-check
/** A guided tour at first use: each step ends when the operator has done it. It can be skipped, and blocks nothing. */

import { onClick } from "./buttons.js";
import { term, text } from "./language.js";
import { byId, keyCap } from "./panels.js";

const STORED_AS = "telex.tour";

/**
 * Of each step what is to be done; `shows` is where it is seen, `begins` what is said instead where the page begins with it.
 * @typedef {import("./vocabulary.js").Action} Action
 * @type {{text: string, of: (action: Action) => boolean, shows: string, begins?: () => string}[]}
 */
const STEPS = [
  { text: term("Drive: hold the key, let go to stop."), of: ({ does }) => does.kind === "drive", shows: "drive-pad" },
  { text: term("Raise the front flippers, as before a step or stairs."), of: jogs("flipper"), shows: "flipper-rows" },
  { text: term("Go on to the ARM, and move a joint of it. Every joint has a pair of keys."), of: jogs("arm"), shows: "arm-rows",
    begins: () => text("Move a joint of the arm. Every joint has a pair of keys.") },
  { text: term("Close the gripper, and open it."), of: jogs("gripper"), shows: "gripper-rows" },
];
const SHOWN = 4; // keys of a step

/** @param {string} node @returns {(action: Action) => boolean} */
function jogs(node) {
  // what moves in each mode moves the camera
  return ({ does, modes }) => does.kind === "jog" && does.node === node && (node !== "arm" || modes.join() === "JOINT");
}

export class Tour {
  /**
   * @param {import("./storage.js").Keeper} storage
   * @param {import("./vocabulary.js").Vocabulary} vocabulary
   * @param {() => void} relabel
   */
  constructor(storage, vocabulary, relabel) {
    this._storage = storage;
    this._relabel = relabel;
    this._vocabulary = vocabulary;
    this._steps = STEPS.map((step) => ({ ...step, keys: vocabulary.all.filter((each) => each.code !== null && step.of(each)) }))
      .filter(({ keys }) => keys.length > 0);
    this._step = -1;
    onClick(byId("tour-skip"), () => this._end());
    onClick(byId("tour-next"), () => this._go(this._step + 1));
    if (storage.getItem(STORED_AS) === null) this.start();
  }

  start() {
    this._go(0);
  }

  /** @param {Iterable<string>} actions  Names of those that are held. */
  see(actions) {
    const keys = this._steps[this._step]?.keys ?? [];
    if (keys.some(({ name }) => [...actions].includes(name))) this._go(this._step + 1);
  }

  /** @param {number} number  Of a step. */
  _go(number) {
    this._unmark();
    const step = this._steps[number];
    if (step === undefined) return this._end();
    this._step = number;
    byId("tour").hidden = false;
    byId("tour-count").textContent = text("{number} of {all}", { number: number + 1, all: this._steps.length });
    // The arm's keys count in its own modes, in which the page of a robot that cannot drive begins.
    const isThere = step.keys[0].modes.includes(this._vocabulary.firstMode);
    byId("tour-text").textContent = (isThere && step.begins?.()) || text(step.text);
    const lead = isThere ? [] : [this._vocabulary.nameOf({ kind: "command", name: "mode" }, [])];
    byId("tour-keys").replaceChildren(...[...lead, ...step.keys.slice(0, SHOWN).map(({ name }) => name)].map(keyCap));
    byId(step.shows).classList.add("toured");
    this._relabel();
  }

  _unmark() {
    for (const { shows } of this._steps) byId(shows).classList.remove("toured");
  }

  _end() {
    this._unmark();
    this._step = -1;
    byId("tour").hidden = true;
    this._storage.setItem(STORED_AS, "seen");
  }
}
