// @ts-check
/** Day and night, the lamps of the scene, and those of the robot. */

import { onClick } from "../buttons.js";
import { Lamps } from "../lamps.js";
import { text, translated } from "../language.js";
import { all, byId, check } from "../panels.js";

export class LightPanel {
  /**
   * @param {import("../vocabulary.js").Vocabulary} vocabulary  Knows which lamps of the robot are switched together.
   * @param {import("../robot_client.js").RobotClient} robot
   */
  constructor(vocabulary, robot) {
    this._robot = robot;
    this._light = { daylight: 1, lamps: 1 };
    for (const button of this._days) onClick(button, () => this._set({ daylight: Number(button.dataset.daylight) }));
    onClick(byId("light-lamps"), () => this._set({ lamps: this._light.lamps > 0 ? 0 : 1 }));
    const place = byId("light-robot");
    this._lamps = new Lamps(vocabulary, robot.bridge, robot.topic, place, "lamps");
    for (const { action, button } of this._lamps.switches) {
      button.title = text(action.title);
      onClick(button, () => { if (!this._lamps.toggle(action.does.names)) robot.warn(text("not connected")); });
    }
    place.hidden = this._lamps.switches.length === 0;
    this._show();
  }

  get _days() {
    return all("#light [data-daylight]");
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
    const answer = await this._robot.request("sim/set_light", light);
    if (answer === null) return;
    this.show(light);
    this._robot.log(translated(answer.message));
  }

  _show() {
    const { daylight, lamps } = this._light;
    check(this._days, ({ dataset }) => Math.abs(Number(dataset.daylight) - daylight) < 0.01);
    byId("light-lamps").setAttribute("aria-checked", String(lamps > 0));
  }
}
