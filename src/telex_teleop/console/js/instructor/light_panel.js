// @ts-check
/** Day and night, the lamps of the scene, and those of the robot. */

import { onClick } from "../buttons.js";
import { Lamps } from "../lamps.js";
import { text } from "../language.js";
import { byId } from "../panels.js";
import { request } from "../services.js";

export class LightPanel {
  /**
   * @param {import("../vocabulary.js").Vocabulary} vocabulary  Knows which lamps of the robot are switched together.
   * @param {import("../bridge.js").Bridge} bridge
   * @param {(name: string) => string} topic
   * @param {(sentence: string) => void} log
   * @param {(sentence: string) => void} warn
   */
  constructor(vocabulary, bridge, topic, log, warn) {
    this._bridge = bridge;
    this._topic = topic;
    this._log = log;
    this._warn = warn;
    this._light = { daylight: 1, lamps: 1 };
    for (const button of this._days) onClick(button, () => this._set({ daylight: Number(button.dataset.daylight) }));
    onClick(byId("light-lamps"), () => this._set({ lamps: this._light.lamps > 0 ? 0 : 1 }));
    const place = byId("light-robot");
    this._lamps = new Lamps(vocabulary, bridge, topic, place, "lamps");
    for (const { action, button } of this._lamps.switches) {
      button.title = text(action.title);
      onClick(button, () => { if (!this._lamps.toggle(action.does.names)) warn(text("not connected")); });
    }
    place.hidden = this._lamps.switches.length === 0;
    this._show();
  }

  get _days() {
    return /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll("#light [data-daylight]"));
  }

  subscribe() {
    this._lamps.advertise();
  }

  /** @param {{daylight: number, lamps: number}} light  That the scene has. */
  show({ daylight, lamps }) {
    this._light = { daylight, lamps };
    this._show();
  }

  /** @param {Partial<{daylight: number, lamps: number}>} change */
  async _set(change) {
    const light = { ...this._light, ...change };
    const answer = await request(this._bridge, this._topic("sim/set_light"), light, this._warn);
    if (answer === null) return;
    this.show(light);
    this._log(answer.message);
  }

  _show() {
    const { daylight, lamps } = this._light;
    for (const button of this._days) button.setAttribute("aria-checked", String(Math.abs(Number(button.dataset.daylight) - daylight) < 0.01));
    byId("light-lamps").setAttribute("aria-checked", String(lamps > 0));
  }
}
