// @ts-check
/** The brief that is read before the start: the goal's picture, the task, what counts, times, and the keys that it takes. */

import { onClick } from "../buttons.js";
import { decimal, onLanguage, text, translated } from "../language.js";
import { bringTexts, metricText, told, zonesOf } from "../language/exercise.js";
import { byId, element, keyCap, rowsOf, setText } from "../panels.js";
import { TEXTS, addressOf, clockText } from "./client.js";

/** @typedef {import("../vocabulary.js").Action} Action */
/** @typedef {import("../language/exercise.js").Told} Told */

/**
 * @typedef {object} Brief  As /training/api/brief/TRIAL has it; times in s.
 * @property {string} trial
 * @property {string} title
 * @property {string} setting
 * @property {string} mode
 * @property {string} description
 * @property {Told} begins
 * @property {{name: string, until: Told}[]} steps
 * @property {boolean} any_order
 * @property {{name: string, when: Told}[]} faults
 * @property {{name: string, when: Told, seconds: number}[]} penalties
 * @property {Metric[]} metrics
 * @property {{most: number, least: number, time: number, trial_time: number}} repetitions
 * @property {string[]} controls
 * @property {{seconds: number, spread: number, provisional: boolean, sees: string} | null} expert
 * @property {number | null} best
 * @property {string} picture
 *
 * @typedef {{text: string, unit: string, more_is_better: boolean, pass: number, expert: [number, number] | null}} Metric
 */

/** Which actions of the vocabulary belong to a control of an exercise. @type {Record<string, (action: Action) => boolean>} */
const NEEDED = {
  tracks: ({ does }) => does.kind === "drive",
  flippers: ({ does }) => (does.kind === "jog" && does.node === "flipper") || does.kind === "preset" || does.kind === "side",
  arm: ({ does }) => does.kind === "tool" || does.kind === "pose" || (does.kind === "command" && does.name === "mode"),
  gripper: ({ does }) => does.kind === "jog" && does.node === "gripper",
  camera: ({ does, name }) => name.startsWith("look:") || (does.kind === "command" && does.name === "next camera"),
  lamps: ({ does }) => does.kind === "lamps",
};
/** Needed always. */
const ALWAYS = ["stop", "e-stop", "slower", "faster", "help"];

export class ExerciseBrief {
  /**
   * @param {import("../vocabulary.js").Vocabulary} vocabulary
   * @param {URLSearchParams} given  What this page's address says.
   * @param {() => void} start  Begins the trial.
   * @param {(reason: string) => void} letGo  Lets go of all keys.
   * @param {() => void} relabel  Shows the keys on the page anew.
   */
  constructor(vocabulary, given, start, letGo, relabel) {
    this._vocabulary = vocabulary;
    this._given = given;
    this._letGo = letGo;
    this._relabel = relabel;
    this._dialog = byId("brief");
    this._picture = /** @type {HTMLImageElement} */ (byId("brief-picture"));
    /** Trial whose brief was opened, or closed, last. */
    this._trial = "";
    this._phase = "idle";
    this._operator = "";
    onClick(byId("brief-start"), start);
    onClick(byId("brief-close"), () => this._close());
    const button = byId("training-brief"); // of the strip, which other pages show without a brief
    button.title = text("Task, what counts, keys");
    button.hidden = false;
    onClick(button, () => (this.isOpen ? this._close() : this._open()));
    this._picture.addEventListener("load", () => setText(byId("brief-caption"), this._caption));
    this._picture.addEventListener("error", () => setText(byId("brief-caption"), text("There is no picture of the goal.")));
    this._caption = "";
    /** What is shown. @type {Brief | null} */
    this._brief = null;
    onLanguage(() => this.isOpen && this._brief !== null && this._fill(this._brief));
  }

  get isOpen() {
    return !this._dialog.hidden;
  }

  /** Open with a trial that can be started, close once it is. @param {import("./client.js").State} state */
  show({ phase, trial, operator }) {
    const isNew = phase === "ready" && trial !== this._trial;
    const begins = phase !== this._phase && phase !== "ready";
    this._phase = phase;
    this._operator = operator;
    byId("brief-start").hidden = phase !== "ready";
    if (trial !== "") this._trial = trial;
    if (isNew) this._open();
    else if (begins && this.isOpen) this._close();
  }

  _close() {
    this._dialog.hidden = true;
  }

  async _open() {
    this._letGo(text("the brief of the exercise"));
    this._dialog.hidden = false;
    const trial = this._trial;
    setText(byId("brief-note"), text("asking for the brief …"));
    try {
      const address = addressOf(`/training/api/brief/${encodeURIComponent(trial)}`, this._given, { name: this._operator });
      const reply = await fetch(address, { cache: "no-store" });
      if (!reply.ok) throw new Error((await reply.text()).trim() || `the video server says ${reply.status}`);
      const brief = await reply.json();
      bringTexts(addressOf(TEXTS, this._given));
      if (trial === this._trial) this._fill(brief);
    } catch (error) {
      setText(byId("brief-note"), text("no brief: {why}", { why: translated(/** @type {Error} */ (error).message) }));
    }
  }

  /** @param {Brief} brief */
  _fill(brief) {
    this._brief = brief;
    setText(byId("brief-note"), "");
    setText(byId("brief-title"), [translated(brief.title), brief.setting === "standard" ? "" : translated(brief.setting), brief.mode === "exam" ? text("EXAM") : ""].filter(Boolean).join(" · "));
    setText(byId("brief-description"), translated(brief.description));
    this._caption = brief.mode === "exam" ? text("As in practice: in an exam things stand elsewhere.") : text("Names and outlines are not to be seen on the robot's cameras.");
    this._caption += zonesOf([brief.begins, ...brief.steps.map(({ until }) => until), ...[...brief.faults, ...brief.penalties].map(({ when }) => when)]);
    setText(byId("brief-caption"), text("the picture is being drawn …"));
    this._picture.src = addressOf(brief.picture, this._given);
    setText(byId("brief-task"), brief.any_order ? text("Task, in any order") : text("Task, in this order"));
    byId("brief-steps").replaceChildren(...brief.steps.map(({ name, until }) => item(translated(name), told(until))));
    fill("brief-faults", brief.faults.map(({ name, when }) => item(translated(name), told(when))));
    fill("brief-penalties", brief.penalties.map(({ name, when, seconds }) => item(`${translated(name)}, + ${decimal(seconds, 1, 0)} s`, told(when))));
    fill("brief-metrics", metricRows(brief.metrics));
    byId("brief-times").replaceChildren(...timesOf(brief).flatMap(([name, words]) => [element("dt", "", name), element("dd", "", words)]));
    byId("brief-keys").replaceChildren(...this._keys(brief.controls));
    this._relabel();
  }

  /** @param {string[]} controls */
  _keys(controls) {
    const has = (/** @type {(action: Action) => boolean} */ needed) => this._vocabulary.all.filter((action) => action.code !== null && needed(action));
    const always = has(({ does }) => does.kind === "command" && ALWAYS.includes(does.name));
    const rows = controls.filter((control) => control in NEEDED).map((control) => keyRow(translated(control), has(NEEDED[control])));
    return [...rows, keyRow(text("always"), always)];
  }
}

/**
 * A list, and its section; hidden where it is empty.
 * @param {string} id
 * @param {Node[]} children
 */
function fill(id, children) {
  const list = byId(id);
  list.replaceChildren(...children);
  /** @type {HTMLElement} */ (list.parentElement).hidden = children.length === 0;
}

/** @param {string} name @param {string} words */
function item(name, words) {
  const made = element("li", "", `${name} `);
  made.append(element("span", "", words));
  return made;
}

/** @param {string} name @param {Action[]} actions */
function keyRow(name, actions) {
  const made = element("div");
  made.append(element("b", "", name), ...rowsOf(actions).map(keysOf));
  return made;
}

/** The keys of actions that belong together, before what they do. @param {Action[]} actions */
function keysOf(actions) {
  const made = element("span");
  for (const { name } of actions) made.append(keyCap(name), " ");
  made.append(actions.length === 1 ? text(actions[0].title) : deedsOf(actions));
  return made;
}

/** What several actions with the same first part of the name do: "x ahead, back". @param {Action[]} actions */
export function deedsOf(actions) {
  const labels = actions.map(({ label }) => text(label));
  const row = text(actions[0].row).split(" ")[0];
  return ["drive", "gripper", "preset", "pose"].includes(actions[0].name.split(":")[0]) ? labels.join(", ") : `${row} ${labels.join(", ")}`;
}

/** @param {Metric[]} metrics */
function metricRows(metrics) {
  if (metrics.length === 0) return [];
  const withExpert = metrics.some(({ expert }) => expert !== null);
  const line = (/** @type {string} */ tag, /** @type {string[]} */ cells) => {
    const made = element("tr");
    made.append(...cells.map((cell) => element(tag, "", cell)));
    return made;
  };
  return [
    line("th", ["", text("pass"), ...(withExpert ? [text("expert")] : [])]),
    ...metrics.map((metric) => line("td", [metricText(metric.text), passOf(metric), ...(withExpert ? [expertOf(metric.expert, metric.unit)] : [])])),
  ];
}

/** @param {Metric} metric */
export function passOf({ pass, unit, more_is_better: more }) {
  if (pass === 0 && !more) return text("none|count");
  const bound = `${decimal(pass, 4, 0)} ${unit}`.trim();
  return more ? text("at least {bound}", { bound }) : text("at most {bound}", { bound });
}

/** @param {[number, number] | null} expert @param {string} unit */
function expertOf(expert, unit) {
  if (expert === null) return "";
  const [mean, spread] = expert;
  return `${decimal(mean, 4, 0)}${spread > 0 ? ` ± ${decimal(spread, 4, 0)}` : ""} ${unit}`.trim();
}

/** Limits and comparisons, with their names. @param {Brief} brief @returns {[string, string][]} */
export function timesOf({ repetitions: { most, least, time, trial_time: trial }, begins, best, expert }) {
  /** @type {[string, string][]} */
  const rows = [[text("clock starts"), text("when {begins}", { begins: told(begins) })]];
  rows.push([text("repetitions"), text("{most}, {least} completed for a verdict", { most: most > 0 ? text("{limit} at most", { limit: most }) : text("as many as you like"), least })]);
  if (time > 0) rows.push([text("each"), text("{limit} at most", { limit: clockText(time) })]);
  if (trial > 0) rows.push([text("trial"), text("{limit} at most", { limit: clockText(trial) })]);
  rows.push([text("your best"), best === null ? text("none in this setting yet") : `${decimal(best, 1)} s`]);
  if (expert !== null) {
    const sees = expert.sees === "" ? "" : text(", which knows {what}", { what: translated(expert.sees) });
    rows.push([text("expert"), `${decimal(expert.seconds, 4, 0)} s${expert.provisional ? text("; provisional, by a script{sees}", { sees }) : ""}`]);
  }
  return rows;
}
