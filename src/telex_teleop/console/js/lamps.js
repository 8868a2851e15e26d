// @ts-check
/** The robot's lamps: which are lit, whoever has switched them, and the buttons that switch them. */

import { makeButton } from "./buttons.js";
import { text } from "./language.js";

const LEVEL = "std_msgs/Float64";

export class Lamps {
  /**
   * @param {import("./vocabulary.js").Vocabulary} vocabulary  Knows which lamps are switched together.
   * @param {import("./bridge.js").Bridge} bridge
   * @param {(name: string) => string} topic
   * @param {HTMLElement} place  Gets the buttons.
   * @param {"command" | "lamps"} key  Of a button's data, under which it has its action's name.
   */
  constructor(vocabulary, bridge, topic, place, key) {
    this._bridge = bridge;
    this._topic = (/** @type {string} */ lamp) => topic(`lamps/${lamp}/command`);
    this._level = (/** @type {string} */ lamp) => topic(`lamps/${lamp}/level`);
    /** @type {Set<string>} */
    this._lit = new Set();
    this.switches = vocabulary.find("lamps").map((action) => {
      const button = makeButton(text(action.label), undefined, "small lamp");
      button.dataset[key] = action.name;
      button.setAttribute("role", "checkbox");
      return { action, button };
    });
    place.append(...this.switches.map(({ button }) => button));
    this._show();
  }

  /** Advertise the topics of the lamps, and follow how they are switched, by whomever. */
  advertise() {
    for (const lamp of this.switches.flatMap(({ action }) => action.does.names)) {
      this._bridge.advertise(this._topic(lamp), LEVEL);
      this._bridge.subscribe({
        topic: this._level(lamp), type: LEVEL, throttle: 0, heard: ({ data }) => {
          this._lit[data > 0 ? "add" : "delete"](lamp);
          this._show();
        },
      });
    }
  }

  /**
   * Light these lamps, or put them out if one of them is lit. They are shown as the robot tells: the bridge may refuse it.
   * @param {string[]} lamps
   * @returns {boolean} Whether it was sent.
   */
  toggle(lamps) {
    const data = lamps.some((lamp) => this._lit.has(lamp)) ? 0 : 1;
    return lamps.every((lamp) => this._bridge.publish(this._topic(lamp), { data }));
  }

  _show() {
    for (const { action, button } of this.switches) {
      button.setAttribute("aria-checked", String(action.does.names.some((/** @type {string} */ lamp) => this._lit.has(lamp))));
    }
  }
}
