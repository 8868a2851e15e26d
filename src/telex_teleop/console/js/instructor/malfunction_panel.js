// @ts-check
/** The instructor's panel of malfunctions: chosen from what can fail, injected now or at the next step. */

import { makeButton, onClick } from "../buttons.js";
import { decimal, onLanguage, text, translated } from "../language.js";
import { byId, element, setText } from "../panels.js";
import { BEGUN } from "../training/client.js";

const TYPE = "telex_msgs/Malfunctions";

/**
 * @typedef {object} Possible  telex_msgs/PossibleMalfunction
 * @property {string} what
 * @property {string} group
 * @property {string} kind
 * @property {string} text
 * @property {string} unit
 * @property {number} default_value
 * @property {number} least
 * @property {number} most
 */
/**
 * @typedef {object} Active  telex_msgs/ActiveMalfunction, what is used of it
 * @property {string} what
 * @property {string} kind
 * @property {number} value
 * @property {boolean} announced
 */
/** @typedef {{what: string, kind: string, value: number, announced: boolean}} Wish */

/** Shown once the simulator tells what can fail. */
export class MalfunctionPanel {
  /** @param {import("../robot_client.js").RobotClient} robot */
  constructor(robot) {
    this._robot = robot;
    /** @type {Possible[]} */
    this._possible = [];
    /** @type {Active[]} */
    this._active = [];
    this._waiting = new AtNextStep();
    onClick(byId("malfunction-now"), () => this._injectNow());
    onClick(byId("malfunction-next"), () => this._injectLater());
    this._what.addEventListener("change", () => this._showRange());
    onLanguage(() => {
      this._offer(this._possible);
      this._showActive();
    });
  }

  subscribe() {
    this._robot.subscribe("sim/malfunctions", TYPE, (message) => this._hear(message));
  }

  get _what() {
    return /** @type {HTMLSelectElement} */ (byId("malfunction-what"));
  }

  get _value() {
    return /** @type {HTMLInputElement} */ (byId("malfunction-value"));
  }

  /** @param {{active: Active[], possible: Possible[]}} message */
  _hear({ active, possible }) {
    byId("malfunction-panel").hidden = possible.length === 0;
    if (JSON.stringify(possible) !== JSON.stringify(this._possible)) this._offer(possible);
    this._active = active;
    this._showActive();
  }

  /** @param {Possible[]} possible */
  _offer(possible) {
    const chosen = this._what.value;
    this._possible = possible;
    const groups = [...new Set(possible.map(({ group }) => group))];
    this._what.replaceChildren(...groups.map((group) => {
      const part = /** @type {HTMLOptGroupElement} */ (element("optgroup"));
      part.label = translated(group);
      part.append(...possible.filter((each) => each.group === group).map((each) => new Option(nameOf(each), keyOf(each))));
      return part;
    }));
    if (possible.some((each) => keyOf(each) === chosen)) this._what.value = chosen;
    this._showRange();
  }

  /** @returns {Possible | undefined} What is chosen. */
  get _chosen() {
    return this._possible.find((each) => keyOf(each) === this._what.value);
  }

  _showRange() {
    const chosen = this._chosen;
    if (chosen === undefined) return;
    this._what.title = translated(chosen.text);
    this._value.hidden = chosen.unit === "";
    this._value.value = "";
    Object.assign(this._value, { min: String(chosen.least), max: String(chosen.most) });
    this._value.placeholder = `${decimal(chosen.default_value, 4, 0)} ${translated(chosen.unit)}`;
    this._value.title = text("{least} to {most} {unit}; empty: {usual}", { ...rangeOf(chosen), usual: decimal(chosen.default_value, 4, 0) });
  }

  /** What is asked for; null where the value is out of its range, which the note then says. @returns {Wish | null} */
  _wish() {
    const chosen = this._chosen;
    if (chosen === undefined) return null;
    const { what, kind, unit, least, most } = chosen;
    const value = unit === "" || this._value.value === "" ? 0 : Number(this._value.value);
    const isDefault = this._value.value === "" || unit === "";
    if (!this._value.validity.valid || !Number.isFinite(value) || (!isDefault && (value < least || value > most))) {
      setText(byId("malfunction-note"), text("the value must be {least} to {most} {unit}", rangeOf(chosen)));
      return null;
    }
    const { checked } = /** @type {HTMLInputElement} */ (byId("malfunction-announced"));
    return { what, kind, value, announced: checked };
  }

  _injectNow() {
    const wish = this._wish();
    if (wish !== null) this._inject(wish);
  }

  _injectLater() {
    const wish = this._wish();
    if (wish === null) return;
    this._waiting.add(wish);
    this._showActive();
  }

  /** @param {Wish} wish */
  async _inject(wish) {
    if (await this._call({ ...wish, on: true })) this._robot.log(wish.announced ? text("{what} fails", { what: nameOf(wish) }) : text("{what} fails, silently", { what: nameOf(wish) }));
  }

  /** @param {{what: string, kind: string}} which */
  async _end({ what, kind }) {
    if (await this._call({ what, kind, value: 0, on: false, announced: false })) this._robot.log(text("{what} works again", { what: nameOf({ what, kind }) }));
  }

  /** @param {object} fields  Of a request of telex_msgs/Malfunction. */
  _call(fields) {
    return this._robot.request("sim/malfunction", fields, (why) => text("malfunction: {why}", { why }));
  }

  /** Hear how far the exercise is. @param {import("../training/client.js").State} state */
  show(state) {
    const later = /** @type {HTMLButtonElement} */ (byId("malfunction-next"));
    later.disabled = !BEGUN.includes(state.phase) || state.steps.length === 0;
    const before = this._waiting.wishes.length;
    for (const wish of this._waiting.hear(state)) this._inject(wish);
    if (this._waiting.wishes.length !== before) this._showActive();
  }

  _showActive() {
    const { wishes } = this._waiting;
    const count = this._active.length;
    setText(byId("malfunction-note"), count === 0 ? text("all works") : text("{count} active", { count }));
    byId("malfunction-active").replaceChildren(
      ...wishes.map((wish) => this._row(text("{what}, at the next step", { what: nameOf(wish) }), text("cancel"), () => {
        this._waiting.remove(wish);
        this._showActive();
      })),
      ...this._active.map((each) => this._row(each.announced ? nameOf(each) : text("{what}, silent", { what: nameOf(each) }), text("end|deed"), () => this._end(each))),
    );
  }

  /**
   * @param {string} words
   * @param {string} deed
   * @param {() => void} act
   */
  _row(words, deed, act) {
    const row = element("li");
    row.append(element("span", "", words), makeButton(deed, act));
    return row;
  }
}

/** Malfunctions that wait for the trainee's next step. */
export class AtNextStep {
  constructor() {
    /** @type {Wish[]} */
    this.wishes = [];
    this._trial = "";
    this._repetition = 0;
    this._done = 0;
  }

  /** @param {Wish} wish */
  add(wish) {
    this.wishes.push(wish);
  }

  /** @param {Wish} wish */
  remove(wish) {
    this.wishes = this.wishes.filter((each) => each !== wish);
  }

  /**
   * Hear how far the exercise is.
   * @param {{trial: string, phase: string, repetition: number, steps_done: boolean[]}} state
   * @returns {Wish[]} Those that are due now; what waits when the trial ends is forgotten.
   */
  hear({ trial, phase, repetition, steps_done }) {
    const done = steps_done.filter(Boolean).length;
    const goesOn = trial === this._trial && repetition === this._repetition;
    const steps = goesOn && done > this._done;
    const isOver = !BEGUN.includes(phase) || trial !== this._trial;
    this._trial = trial;
    this._repetition = repetition;
    this._done = done;
    if (!steps && !isOver) return [];
    const due = isOver ? [] : this.wishes;
    this.wishes = [];
    return due;
  }
}

/** @param {{what: string, kind: string}} which */
const keyOf = ({ what, kind }) => `${what}/${kind}`;

/** @param {{what: string, kind: string}} which */
const nameOf = ({ what, kind }) => `${translated(what)}${text(": |joint")}${kindOf(kind)}`;

/** A gripper that has lost its force is no link that is lost. @param {string} kind */
const kindOf = (kind) => (kind === "lost" ? text("lost|force") : translated(kind));

/** @param {Possible} range */
const rangeOf = ({ least, most, unit }) => ({ least: decimal(least, 4, 0), most: decimal(most, 4, 0), unit: translated(unit) });
