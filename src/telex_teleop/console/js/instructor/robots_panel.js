// @ts-check
/** The other robots of the scene: who has control, their emergency stops, and the exam's list at their bridges. */

import { Bridge } from "../bridge.js";
import { makeButton } from "../buttons.js";
import { locateBridge } from "../config.js";
import { EmergencyStop } from "../emergency_stop.js";
import { text, translated } from "../language.js";
import { byId, element, setText } from "../panels.js";
import { TYPES } from "../robot.js";
import { RobotClient } from "../robot_client.js";
import { robotOf } from "../several_robots.js";

/** One of them: a line of the card, and a connection to its bridge. */
class OtherRobot {
  /**
   * @param {string} name
   * @param {URLSearchParams} given  What this page connects with.
   * @param {(sentence: string, level?: "info" | "warning" | "alarm") => void} log
   */
  constructor(name, given, log) {
    this.name = name;
    this._estopped = false;
    this._driver = "";
    /** Trial for which an exam's list was last said to hold there; empty: none. */
    this._exam = "";
    const asked = new URLSearchParams(given);
    asked.set("robot", name);
    this.row = element("li", "", "");
    this.row.dataset.robot = name;
    const link = document.createElement("a");
    link.href = `/instructor?${asked}`;
    link.textContent = name;
    this._state = element("span", "num", "");
    this._release = makeButton(text("release e-stop"), () => this.estop.set(false));
    this._release.tabIndex = -1;
    this.row.append(link, " ", this._state, " ", this._release);
    this._bridge = new Bridge(() => locateBridge(asked), {
      opened: () => {
        this.estop.connected();
        this._show();
      },
      lost: (reason) => {
        log(`${name}: ${text("connection lost: {reason}", { reason: translated(reason) })}`, "alarm");
        this.estop.lost();
        this._driver = "";
        this._show();
      },
      refused: (sentence) => log(`${name}: ${translated(sentence)}`, "warning"),
    });
    this.estop = new EmergencyStop(this._bridge, `/${name}/e_stop`, (sentence) => log(`${name}: ${sentence}`, "alarm"));
    this.estop.advertise();
    this.client = new RobotClient(
      this._bridge, (each) => `/${name}/${each}`, (sentence) => log(`${name}: ${sentence}`), (sentence) => log(`${name}: ${sentence}`, "warning"),
    );
    this.client.subscribe("bridge/exam", "std_msgs/String", ({ data }) => {
      this._exam = data;
    });
    this._bridge.subscribe({
      topic: `/${name}/sim/status`, type: TYPES.simStatus, throttle: 0, heard: (status) => {
        this.estop.hear(status);
        this._estopped = status.e_stop;
        this._show();
      },
    });
    this._bridge.subscribe({
      topic: `/${name}/bridge/clients`, type: "telex_msgs/BridgeClients", throttle: 0, heard: ({ clients }) => {
        const driver = clients.find((/** @type {any} */ client) => client.in_control);
        this._driver = driver === undefined ? "" : driver.name || text("client {id}", { id: driver.id });
        this._show();
      },
    });
    this._show();
    this._bridge.start();
  }

  /** End an exam's list where one holds. @returns {Promise<boolean>} Whether none holds any more, as far as is known. */
  async endExam() {
    if (this._exam === "") return true;
    return (await this.client.request("bridge/end_exam", {}, (why) => text("exam: {why}", { why }))) !== null;
  }

  _show() {
    const { connected } = this._bridge;
    const driven = this._driver === "" ? text("nobody has control") : text("{name} has control", { name: this._driver });
    setText(this._state, connected ? `${this._estopped ? `${text("E-STOP")} · ` : ""}${driven}` : text("not connected"));
    this._release.hidden = !(connected && this._estopped);
  }
}

/** A card that is shown where the scene has further robots. */
export class RobotsPanel {
  /**
   * @param {import("../config.js").Config} config
   * @param {URLSearchParams} given
   * @param {(sentence: string, level?: "info" | "warning" | "alarm") => void} log
   */
  constructor(config, given, log) {
    const names = (config.robots ?? []).map(({ name }) => name).filter((name) => name !== robotOf(config));
    this._others = names.map((name) => new OtherRobot(name, given, log));
    byId("robots").append(...this._others.map(({ row }) => row));
    byId("robots-panel").hidden = names.length === 0;
  }

  /** Stop the other robots as well. */
  stopAll() {
    for (const other of this._others) other.estop.set(true);
  }

  /** End an exam's list at their bridges. @returns {Promise<boolean>} Whether none holds any more, as far as is known. */
  async endExam() {
    return (await Promise.all(this._others.map((other) => other.endExam()))).every(Boolean);
  }

  /**
   * The first robot, in whose namespace the simulator is.
   * @param {import("../config.js").Config} config
   * @returns {RobotClient | undefined} Undefined: it is the one that the page shows.
   */
  first({ simulator = "" }) {
    return this._others.find(({ name }) => `/${name}` === simulator)?.client;
  }
}
