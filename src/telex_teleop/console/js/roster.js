// @ts-check
/** Clients of the bridge and who has control, with the instructor's actions on them. */

import { ask } from "./ask.js";
import { makeButton, onClick } from "./buttons.js";
import { text, translated } from "./language.js";
import { byId, element, setText } from "./panels.js";

const TYPE = "telex_msgs/BridgeClients";
const NOBODY = "";

/** @param {number} seconds */
function age(seconds) {
  if (seconds < 60) return `${Math.max(0, Math.floor(seconds))} s`;
  if (seconds < 3600) return `${Math.floor(seconds / 60)} min`;
  return `${Math.floor(seconds / 3600)} h ${Math.floor((seconds % 3600) / 60)}`;
}

/** @param {{secs: number, nsecs: number}} time */
const seconds = ({ secs, nsecs }) => secs + 1e-9 * nsecs;

/** A client's row; the element is kept, so that a click on it is not lost. */
class Line {
  /** @param {() => void} give */
  constructor(give) {
    this.row = document.createElement("tr");
    this._cells = Array.from({ length: 5 }, () => this.row.appendChild(document.createElement("td")));
    this._button = makeButton(text("hand over"), give);
    this._holds = element("span", "holds", text("in control"));
    this._cells[4].append(this._button, this._holds);
  }

  /**
   * @param {any} client   telex_msgs/BridgeClient
   * @param {boolean} isThis
   * @param {number} now   s
   */
  show(client, isThis, now) {
    const [name, role, from, since] = this._cells;
    const dropped = client.dropped_commands > 0 ? text(" · {count} dropped", { count: client.dropped_commands }) : "";
    setText(name, `${client.name || text("client {id}", { id: client.id })}${isThis ? text(" (you)") : ""}${dropped}`);
    name.title = text("client {id}", { id: client.id }) + dropped;
    setText(role, translated(client.role));
    setText(from, client.address);
    setText(since, age(now - seconds(client.connected_since)));
    this.row.dataset.client = client.id;
    this.row.dataset.holds = String(client.in_control);
    this._button.hidden = client.in_control || isThis;
    this._holds.hidden = !client.in_control;
  }
}

export class Roster {
  /** @param {import("./robot_client.js").RobotClient} robot */
  constructor(robot) {
    this._robot = robot;
    /** This page's id; null: not known. @type {string | null} */
    this._id = null;
    this._holder = NOBODY;
    /** @type {any[]} */
    this._clients = [];
    /** @type {Map<string, Line>} */
    this._lines = new Map();
    onClick(byId("take"), () => this._take());
    onClick(byId("give-up"), () => this._do("release_control", {}, text("control is released")));
    this._show();
  }

  subscribe() {
    this._robot.subscribe("bridge/clients", TYPE, (message) => this._hear(message));
  }

  /** Ask, after every new connection, who this page is. */
  async connected() {
    const answer = await this._robot.request("bridge/who_am_i", {});
    if (answer !== null) this._id = answer.message;
    this._show();
  }

  disconnected() {
    this._id = null;
    this._holder = NOBODY;
    this._clients = [];
    this._show();
  }

  /** Names of the clients that may drive and are no instructors. */
  get drivers() {
    return this._clients.filter(({ role }) => role !== "instructor").map(({ name }) => name);
  }

  /** @param {string} id */
  _nameOf(id) {
    return this._clients.find((client) => client.id === id)?.name || text("client {id}", { id });
  }

  /** @param {any} message  telex_msgs/BridgeClients */
  _hear({ header, holder, clients }) {
    const before = this._holder;
    this._holder = holder;
    this._clients = clients;
    if (holder !== before) this._robot.log(holder === NOBODY ? text("nobody has control") : text("{name} has control", { name: this._nameOf(holder) }));
    this._show(seconds(header.stamp));
  }

  async _take() {
    const other = this._holder !== NOBODY && this._holder !== this._id;
    if (other && !(await ask(text("Take control from {name}? What moves stops.", { name: this._nameOf(this._holder) }), text("take over")))) return;
    await this._do("take_control", {}, text("you have control"));
  }

  /** @param {string} id */
  async _give(id) {
    const from = this._holder !== NOBODY && this._holder !== this._id ? text(" It is taken from {name}.", { name: this._nameOf(this._holder) }) : "";
    if (!(await ask(text("Give control to {name}?{from} What moves stops.", { name: this._nameOf(id), from }), text("hand over")))) return;
    await this._do("hand_over", { client: id }, text("control is given to {name}", { name: this._nameOf(id) }));
  }

  /**
   * @param {string} service
   * @param {object} args
   * @param {string} done  What to log when it is.
   */
  async _do(service, args, done) {
    if (await this._robot.request(`bridge/${service}`, args)) this._robot.log(done);
  }

  /** @param {number} [now]  Of the bridge's clock (s). */
  _show(now = 0) {
    const gone = new Set(this._lines.keys());
    for (const client of this._clients) {
      gone.delete(client.id);
      let line = this._lines.get(client.id);
      if (line === undefined) {
        line = new Line(() => this._give(client.id));
        this._lines.set(client.id, line);
        byId("roster").append(line.row);
      }
      line.show(client, client.id === this._id, now);
    }
    for (const id of gone) {
      this._lines.get(id)?.row.remove();
      this._lines.delete(id);
    }
    const isMine = this._holder !== NOBODY && this._holder === this._id;
    byId("control").dataset.state = this._holder === NOBODY ? "free" : isMine ? "mine" : "other";
    setText(byId("control-holder"), this._holder === NOBODY ? text("free") : isMine ? text("you") : this._nameOf(this._holder));
    /** @type {HTMLButtonElement} */ (byId("take")).disabled = this._id === null || isMine;
    /** @type {HTMLButtonElement} */ (byId("give-up")).disabled = !isMine;
  }
}
