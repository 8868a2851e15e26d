// @ts-check
/** The trainee: what he sees and holds now, and what is said to him. */

import { decimal, text, translated } from "../language.js";
import { byId, setText } from "../panels.js";
import { request } from "../services.js";
import { TYPES } from "../training/client.js";

const TEXT_TYPE = "telex_msgs/TrainingText";
const OLD = 2000; // ms without a word of his page, which speaks twice a second

export class TraineeCard {
  /**
   * @param {import("../vocabulary.js").Vocabulary} vocabulary
   * @param {import("../bridge.js").Bridge} bridge
   * @param {(name: string) => string} topic
   * @param {string} by  Who speaks.
   * @param {(sentence: string) => void} log
   * @param {(sentence: string) => void} warn
   */
  constructor(vocabulary, bridge, topic, by, log, warn) {
    this._vocabulary = vocabulary;
    this._bridge = bridge;
    this._topic = topic;
    this._by = by;
    this._log = log;
    this._warn = warn;
    this._heard = -Infinity;
    /** @type {{number: number, text: string, by: string, read: boolean}} */
    this._told = { number: 0, text: "", by: "", read: true };
    byId("trainee-text").addEventListener("submit", (event) => {
      event.preventDefault();
      this._say();
    });
  }

  subscribe() {
    this._bridge.subscribe({
      topic: this._topic("console/telemetry"), type: TYPES.telemetry, throttle: 0, heard: ({ data }) => this._see(data),
    });
    this._bridge.subscribe({
      topic: this._topic("training/text"), type: TEXT_TYPE, throttle: 0, heard: (told) => {
        if (told.read && told.text !== "" && told.number === this._told.number && !this._told.read) this._log(text("read: {words}", { words: told.text }));
        this._told = told;
        this._showText();
      },
    });
  }

  /** @param {string} data  JSON, as his page tells it; that of another GUI may lack anything. */
  _see(data) {
    let seen;
    try {
      seen = JSON.parse(data);
    } catch {
      return;
    }
    this._heard = performance.now();
    const { view, picture_age: age, held } = seen ?? {};
    const old = Number.isFinite(age) ? text("picture {n} s old", { n: decimal(age, 1) }) : text("no picture");
    setText(byId("trainee-view"), typeof view === "string" ? `${translated(view)} · ${old}` : "–");
    setText(byId("trainee-keys"), Array.isArray(held) ? held.map((name) => this._nameOf(String(name))).join(", ") || text("nothing") : "–");
  }

  /** @param {string} name  Of an action. */
  _nameOf(name) {
    const action = this._vocabulary.get(name);
    if (action === undefined) return name.slice(0, 40);
    return action.cap === null ? text(action.title) : `${action.cap} ${text(action.title)}`;
  }

  /** Show nothing where nothing is told any more. */
  fade() {
    if (performance.now() - this._heard < OLD) return;
    for (const id of ["trainee-view", "trainee-keys"]) setText(byId(id), "–");
  }

  async _say() {
    const field = /** @type {HTMLInputElement} */ (byId("trainee-words"));
    const said = { text: field.value.trim(), by: this._by };
    if (await request(this._bridge, this._topic("training/tell"), said, this._warn)) field.value = "";
  }

  _showText() {
    const { text: words, read } = this._told;
    const state = words === "" ? "" : read ? text("✔ read: {words}", { words }) : text("not read yet: {words}", { words });
    setText(byId("trainee-note"), state);
    byId("trainee-note").title = state;
  }
}
