// @ts-check
/** The chooser of exercises: pictures, settings, one's own best, and whose trial it will be. */

import { makeButton, onClick } from "../buttons.js";
import { onLanguage, text, translated } from "../language.js";
import { bringTexts } from "../language/exercise.js";
import { byId, element, setText } from "../panels.js";
import { TEXTS, addressOf, clockText, rememberOperator, rememberedOperator } from "./client.js";

export class ExerciseChooser {
  /**
   * @param {import("./client.js").TrainingClient} client
   * @param {URLSearchParams} given
   * @param {(reason: string) => void} letGo
   */
  constructor(client, given, letGo) {
    this._client = client;
    this._given = given;
    this._letGo = letGo;
    this._dialog = byId("exercises");
    const name = this._nameField;
    name.value = rememberedOperator();
    name.addEventListener("change", () => {
      rememberOperator(name.value.trim());
      this._fill();
    });
    name.addEventListener("input", () => this._showProgressLink());
    onClick(byId("exercises-open"), () => this.toggle());
    onClick(byId("exercises-close"), () => this.toggle());
    onLanguage(() => this.isOpen && this._fill());
  }

  get _nameField() {
    return /** @type {HTMLInputElement} */ (byId("exercises-operator"));
  }

  /** Lead to the standing of whoever is named: pages are shown by name. */
  _showProgressLink() {
    const link = /** @type {HTMLAnchorElement} */ (byId("exercises-progress"));
    const name = this._nameField.value.trim();
    link.hidden = name === "";
    link.href = addressOf("/progress/", this._given, { name, person: name });
  }

  get isOpen() {
    return !this._dialog.hidden;
  }

  toggle() {
    this._letGo(text("the list of exercises"));
    this._dialog.hidden = this.isOpen;
    if (this.isOpen) this._fill();
  }

  async _fill() {
    this._showProgressLink();
    const note = byId("exercises-note");
    setText(note, text("asking for the exercises …"));
    try {
      const exercises = await this._client.list(this._nameField.value.trim());
      bringTexts(addressOf(TEXTS, this._given));
      setText(note, exercises.length === 0 ? text("there are no exercises") : "");
      byId("exercises-list").replaceChildren(...exercises.map((exercise) => this._card(exercise)));
    } catch (error) {
      setText(note, text("no exercises: {why}; is the training node running?", { why: translated(/** @type {Error} */ (error).message) }));
    }
  }

  /** @param {import("./client.js").Exercise} exercise */
  _card(exercise) {
    const card = element("article");
    if (exercise.preview !== "") {
      const picture = document.createElement("img");
      picture.src = addressOf(exercise.preview, this._given);
      picture.alt = "";
      picture.loading = "lazy";
      card.append(picture);
    }
    card.append(element("h3", "", translated(exercise.title || exercise.name)), element("p", "", translated(exercise.problem || exercise.description)));
    if (exercise.problem !== "") {
      card.dataset.state = "broken";
      return card;
    }
    const row = element("div");
    const setting = chooser(exercise.settings, text("setting"));
    const mode = chooser(exercise.modes, text("mode"));
    const open = makeButton(text("open"), () => this._open(exercise.name, setting.value, mode.value));
    const best = element("span", "note", exercise.best > 0 ? text("your best {time}", { time: clockText(exercise.best) }) : "");
    row.append(setting, mode, open, best);
    card.append(row);
    return card;
  }

  /**
   * @param {string} exercise
   * @param {string} setting
   * @param {string} mode
   */
  async _open(exercise, setting, mode) {
    const operator = this._nameField.value.trim();
    if (operator === "") {
      setText(byId("exercises-note"), text("type your name first: the trial will be yours"));
      this._nameField.focus();
      return;
    }
    rememberOperator(operator);
    setText(byId("exercises-note"), text("opening …"));
    const opened = await this._client.act("open", { exercise, setting, mode, operator });
    setText(byId("exercises-note"), opened ? "" : text("not opened; the messages say why"));
    if (opened) this._dialog.hidden = true;
  }
}

/**
 * @param {string[]} names
 * @param {string} label
 */
function chooser(names, label) {
  const made = document.createElement("select");
  made.setAttribute("aria-label", label);
  for (const name of names) made.append(new Option(translated(name), name));
  made.hidden = names.length < 2;
  return made;
}
