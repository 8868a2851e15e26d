// @ts-check
/** The trainee: what he sees and holds now, and what is said to him. */

import { decimal, text, translated } from "../language.js";
import { byId, setText } from "../panels.js";
import { TYPES } from "../training/client.js";

const TEXT_TYPE = "telex_msgs/TrainingText";
const OLD = 2000; // ms without a message from the trainee's page, which sends two a second

export class TraineeCard {
  /**
   * @param {import("../vocabulary.js").Vocabulary} vocabulary
   * @param {import("../robot_client.js").RobotClient} robot
   * @param {string} by  Who speaks.
   */
  constructor(vocabulary, robot, by) {
    this._vocabulary = vocabulary;
    this._robot = robot;
    this._by = by;
    this._heard = -Infinity;
    /** @type {{number: number, text: string, by: string, read: boolean}} */
    this._told = { number: 0, text: "", by: "", read: true };
    byId("trainee-text").addEventListener("submit", (event) => {
      event.preventDefault();
      this._say();
    });
  }

  subscribe() {
    this._robot.subscribe("console/telemetry", TYPES.telemetry, ({ data }) => this._see(data));
    this._robot.subscribe("training/text", TEXT_TYPE, (told) => {
      if (told.read && told.text !== "" && told.number === this._told.number && !this._told.read) this._robot.log(text("read: {words}", { words: told.text }));
      this._told = told;
      this._showText();
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
    if (await this._robot.request("training/tell", said)) field.value = "";
  }

  _showText() {
    const { text: words, read } = this._told;
    const state = words === "" ? "" : read ? text("✔ read: {words}", { words }) : text("not read yet: {words}", { words });
    setText(byId("trainee-note"), state);
    byId("trainee-note").title = state;
  }
}
