// @ts-check
/** The instructor's panel of exercises: opened for a trainee, started, aborted; notes and marks. */

import { ask } from "../ask.js";
import { onClick } from "../buttons.js";
import { text, translated } from "../language.js";
import { bringTexts } from "../language/exercise.js";
import { byId, element, setText } from "../panels.js";
import { BEGUN, TEXTS, addressOf } from "./client.js";


/** @typedef {import("./client.js").State} State */

export class ExercisePanel {
  /**
   * @param {import("./client.js").TrainingClient} client
   * @param {URLSearchParams} given  What this page's address says.
   * @param {() => string[]} connected  Names of those who are connected to drive.
   * @param {(sentence: string) => void} log
   */
  constructor(client, given, connected, log) {
    this._client = client;
    this._given = given;
    this._connected = connected;
    this._log = log;
    /** @type {import("./client.js").Exercise[]} */
    this._exercises = [];
    /** Names under which trials were done. @type {string[]} */
    this._known = [];
    /** @type {State | null} */
    this._state = null;
    this._listen();
    this._showState();
  }

  _listen() {
    this._names.addEventListener("change", () => this._showChoices());
    // The offered names are refreshed whenever one is going to be typed.
    this._operator.addEventListener("focus", () => this._offerNames());
    onClick(byId("exercise-open"), () => this._open());
    onClick(byId("exercise-start"), () => this._client.act("start"));
    onClick(byId("exercise-abort"), () => this._abort());
    onClick(byId("exercise-passed"), () => this._remark("mark", "passed"));
    onClick(byId("exercise-failed"), () => this._remark("mark", "failed"));
    byId("exercise-remarks").addEventListener("submit", (event) => {
      event.preventDefault();
      this._remark("note");
    });
  }

  get _names() {
    return select("exercise-name");
  }

  get _operator() {
    return field("exercise-operator");
  }

  /** Ask which exercises there are, and who has done some; after every new connection. */
  async list() {
    try {
      this._exercises = (await this._client.list("")).filter(({ problem }) => problem === "");
      bringTexts(addressOf(TEXTS, this._given));
    } catch (error) {
      setText(byId("exercise-note"), text("no exercises: {why}", { why: translated(/** @type {Error} */ (error).message) }));
      return;
    }
    const chosen = this._names.value;
    fill(this._names, this._exercises.map(({ name, title }) => [name, translated(title || name)]), chosen);
    this._showChoices();
    this._showState();
    this._known = await this._askForNames();
    this._offerNames();
  }

  /** @returns {Promise<string[]>} */
  async _askForNames() {
    try {
      const reply = await fetch(addressOf("/training/api/sheets", this._given), { cache: "no-store" });
      if (!reply.ok) return [];
      return (await reply.json()).map((/** @type {any} */ sheet) => sheet.operator);
    } catch {
      return []; // names can be typed as well
    }
  }

  _offerNames() {
    const names = new Set([...this._connected(), ...this._known].filter((name) => name !== ""));
    byId("exercise-names").replaceChildren(...[...names].map((name) => new Option(name, name)));
  }

  _showChoices() {
    const exercise = this._exercises.find(({ name }) => name === this._names.value);
    for (const [id, values] of /** @type {[string, string[]][]} */ ([
      ["exercise-setting", exercise?.settings ?? []],
      ["exercise-mode", exercise?.modes ?? []],
    ])) {
      fill(select(id), values.map((value) => [value, translated(value)]), select(id).value);
      select(id).disabled = values.length < 2;
    }
  }

  /** @param {State} state */
  show(state) {
    const ended = state.phase === "ended" && this._state?.phase !== "ended";
    this._state = state;
    if (ended && state.operator !== "" && !this._known.includes(state.operator)) this._known.push(state.operator);
    this._showState();
  }

  _showState() {
    const phase = this._state?.phase ?? "idle";
    setText(byId("exercise-note"), stateText(this._state));
    byId("exercise-note").title = stateText(this._state);
    const begun = BEGUN.includes(phase);
    button("exercise-open").disabled = begun || this._exercises.length === 0;
    button("exercise-start").disabled = phase !== "ready";
    button("exercise-abort").disabled = !begun;
    document.body.dataset.trial = begun ? "begun" : "";
    byId("exercise-remarks").hidden = !begun && phase !== "ended";
    // Notes can be made during a trial, marks only once it has ended.
    button("exercise-passed").disabled = button("exercise-failed").disabled = phase !== "ended";
  }

  async _open() {
    const operator = this._operator.value.trim();
    if (operator === "") {
      setText(byId("exercise-note"), text("whose trial will it be? type a name"));
      this._operator.focus();
      return;
    }
    const [exercise, setting, mode] = ["exercise-name", "exercise-setting", "exercise-mode"].map((id) => select(id).value);
    setText(byId("exercise-note"), text("opening …"));
    if (await this._client.act("open", { exercise, setting, mode, operator })) this._log(text("{exercise} is open for {operator}", { exercise: this._names.selectedOptions[0]?.text ?? exercise, operator }));
    this._showState();
  }

  async _abort() {
    const state = this._state;
    if (state === null) return;
    if (await ask(text("Abort the trial of {name}? It ends, and its sheet is written.", { name: state.operator || text("nobody") }), text("abort"))) this._client.act("call_off");
  }

  /**
   * @param {"mark" | "note"} kind
   * @param {string} [verdict]
   */
  async _remark(kind, verdict = "") {
    const words = field("exercise-remark").value.trim();
    if (words === "" || this._state === null) {
      setText(byId("exercise-note"), kind === "mark" ? text("a mark needs a reason") : text("a note needs a text"));
      field("exercise-remark").focus();
      return;
    }
    const { trial } = this._state;
    const said = kind === "mark" ? { value: verdict, reason: words } : { value: words, reason: this._given.get("name") ?? "" };
    if (!(await this._client.act("note", { trial, kind, ...said }))) return;
    this._log(kind === "mark" ? text("marked as {verdict}: {why}", { verdict: translated(verdict), why: words }) : text("noted: {note}", { note: words }));
    field("exercise-remark").value = "";
    this._showState();
  }
}

/** Whose trial of what it is, and how far. @param {State | null} state */
export function stateText(state) {
  if (state === null || state.phase === "idle") return text("none is open");
  const { operator, title, setting, mode, phase, verdict, valid } = state;
  const outcome = valid ? translated(verdict) || text("no verdict") : text("not valid");
  const end = phase === "ended" ? outcome : translated(phase);
  return [operator || text("no name"), setting === "standard" ? translated(title) : `${translated(title)}, ${translated(setting)}`, translated(mode), end].join(" · ");
}

/**
 * Offer choices, with the one that was chosen before if it is still there.
 * @param {HTMLSelectElement} where
 * @param {string[][]} choices  Values and their texts.
 * @param {string} chosen
 */
function fill(where, choices, chosen) {
  where.replaceChildren(...choices.map(([value, words]) => {
    const option = /** @type {HTMLOptionElement} */ (element("option", "", words));
    option.value = value;
    return option;
  }));
  if (choices.some(([value]) => value === chosen)) where.value = chosen;
}

const select = (/** @type {string} */ id) => /** @type {HTMLSelectElement} */ (byId(id));
const field = (/** @type {string} */ id) => /** @type {HTMLInputElement} */ (byId(id));
const button = (/** @type {string} */ id) => /** @type {HTMLButtonElement} */ (byId(id));
