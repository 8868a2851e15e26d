// @ts-check
/** Day and night, the lamps of the scene, and those of the robot. */

import { onClick } from "../buttons.js";
import { text } from "../language.js";
import { byId, element } from "../panels.js";

const NUMBER = "std_msgs/Float64";

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
    /** @type {Set<string>} */
    this._lit = new Set();
    this._switches = vocabulary.find("lamps");
    for (const button of this._days) onClick(button, () => this._set({ daylight: Number(button.dataset.daylight) }));
    onClick(byId("light-lamps"), () => this._set({ lamps: this._light.lamps > 0 ? 0 : 1 }));
    byId("light-robot").append(...this._switches.map((action) => {
      const button = /** @type {HTMLButtonElement} */ (element("button", "small lamp", text(action.label)));
      Object.assign(button, { type: "button", title: text(action.title) });
      button.dataset.lamps = action.name;
      button.setAttribute("role", "checkbox");
      onClick(button, () => this._toggle(action.does.names));
      return button;
    }));
    byId("light-robot").hidden = this._switches.length === 0;
    this._show();
  }

  get _days() {
    return /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll("#light [data-daylight]"));
  }

  subscribe() {
    for (const lamp of this._switches.flatMap(({ does }) => does.names)) {
      const topic = this._topic(`lamps/${lamp}/command`);
      this._bridge.advertise(topic, NUMBER);
      // The trainee switches them as well.
      this._bridge.subscribe({
        topic, type: NUMBER, throttle: 0, heard: ({ data }) => {
          this._lit[data > 0 ? "add" : "delete"](lamp);
          this._show();
        },
      });
    }
  }

  /** @param {{daylight: number, lamps: number}} light  That the scene has. */
  show({ daylight, lamps }) {
    this._light = { daylight, lamps };
    this._show();
  }

  /** @param {Partial<{daylight: number, lamps: number}>} change */
  async _set(change) {
    const light = { ...this._light, ...change };
    try {
      const { success, message } = await this._bridge.call(this._topic("sim/set_light"), light);
      if (success) this.show(light);
      (success ? this._log : this._warn)(message);
    } catch (error) {
      this._warn(/** @type {Error} */ (error).message);
    }
  }

  /** @param {string[]} lamps  Lights these lamps, or puts them out if one of them burns. */
  _toggle(lamps) {
    const data = lamps.some((lamp) => this._lit.has(lamp)) ? 0 : 1;
    for (const lamp of lamps) {
      if (!this._bridge.publish(this._topic(`lamps/${lamp}/command`), { data })) return this._warn(text("not connected"));
    }
    return undefined;
  }

  _show() {
    const { daylight, lamps } = this._light;
    for (const button of this._days) button.setAttribute("aria-checked", String(Math.abs(Number(button.dataset.daylight) - daylight) < 0.01));
    byId("light-lamps").setAttribute("aria-checked", String(lamps > 0));
    for (const { name, does } of this._switches) {
      const isLit = does.names.some((lamp) => this._lit.has(lamp));
      document.querySelector(`#light-robot [data-lamps="${name}"]`)?.setAttribute("aria-checked", String(isLit));
    }
  }
}
