// @ts-check
/** Which of the connected clients holds control of the robot. */

import { text, translated } from "./language.js";
import { byId, setText } from "./panels.js";

const TYPE = "telex_msgs/BridgeClients";
const FREE = "";
const WHO_WITHIN = 25000; // ms, for the slowest line takes 10 s each way

export class ControlView {
  /**
   * @param {import("./bridge.js").Bridge} bridge
   * @param {(name: string) => string} topic
   * @param {(reason: string) => boolean} letGo
   * @param {(sentence: string) => void} warn
   */
  constructor(bridge, topic, letGo, warn) {
    this._bridge = bridge;
    this._topic = topic;
    this._letGo = letGo;
    this._warn = warn;
    /** This page's name at the bridge; null: a bridge without a control lock, or not known yet. @type {string | null} */
    this._id = null;
    this._holder = FREE;
    /** Whether this page has given control up, and the bridge has not answered yet. */
    this.givesUp = false;
    /** @type {{id: string, name: string}[]} */
    this._clients = [];
    /** Counts connections. */
    this._connections = 0;
  }

  /** Whether somebody else holds control. */
  get isWatching() {
    return this._id !== null && this._holder !== FREE && this._holder !== this._id;
  }

  /** Whether this page knows which of the clients it is. */
  get isKnown() {
    return this._id !== null;
  }

  /** Whether this page holds control; without a control lock everybody does. */
  get isMine() {
    return this._id === null || this._holder === this._id;
  }

  /** What the holder is called. */
  get holderName() {
    if (this._holder === FREE) return text("somebody");
    const holder = this._clients.find(({ id }) => id === this._holder);
    return holder?.name || text("client {id}", { id: this._holder });
  }

  subscribe() {
    this._bridge.subscribe({
      topic: this._topic("bridge/clients"), type: TYPE, throttle: 0, heard: (message) => this._hear(message),
    });
  }

  /** Ask, after every new connection, who this page is. */
  async connected() {
    const connection = (this._connections += 1);
    let id = null, isLate = false; // without an answer it is a bridge that has no control lock
    do {
      try {
        id = (await this._bridge.call(this._topic("bridge/who_am_i"), {}, WHO_WITHIN)).message;
        isLate = false;
      } catch (error) {
        isLate = /** @type {Error} */ (error).name === "TimeoutError";
      }
      if (connection !== this._connections) return;
    } while (isLate);
    this._id = id;
    this._show();
  }

  disconnected() {
    this._connections += 1;
    this._id = null;
    this._holder = FREE;
    this._show();
  }

  /** Take control, or give it up. */
  async toggle() {
    if (this.givesUp) return;
    const isMine = this._holder === this._id;
    if (isMine) this._letGo(text("you gave up control"));
    this.givesUp = isMine;
    try {
      const answer = isMine
        // A command sent after it would take control again.
        ? await this._bridge.callAlone(this._topic("bridge/release_control"), {})
        : await this._bridge.call(this._topic("bridge/take_control"), {});
      if (!answer.success) this._warn(translated(answer.message));
    } catch (error) {
      this._warn(translated(/** @type {Error} */ (error).message));
    } finally {
      this.givesUp = false;
    }
  }

  /** @param {any} message  telex_msgs/BridgeClients */
  _hear({ holder, clients }) {
    const wasHeld = this._holder === this._id;
    this._holder = holder;
    this._clients = clients;
    if (wasHeld && holder !== this._id && this._id !== null) {
      const news = holder === FREE ? text("control was taken away") : text("{name} has control now", { name: this.holderName });
      if (!this._letGo(news) && holder !== FREE) this._warn(news);
    }
    this._show();
  }

  _show() {
    byId("control").hidden = this._id === null;
    const state = this._holder === FREE ? "free" : this.isWatching ? "watching" : "mine";
    byId("control").dataset.state = state;
    setText(byId("control-text"), { free: text("control free"), watching: text("WATCHING · {name}", { name: this.holderName }), mine: text("you control") }[state]);
    byId("control-text").title = byId("control-text").textContent ?? "";
    setText(byId("control-button"), state === "mine" ? text("release") : text("take"));
    document.body.classList.toggle("watching", this.isWatching);
  }
}
