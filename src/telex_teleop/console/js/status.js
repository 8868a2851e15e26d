// @ts-check
/** Header, bands over the picture, warnings and the log of messages. */

import { byId } from "./panels.js";

/** Time (ms) without a word after which the link counts as silent. */
export const SILENT_AFTER = 1000;

/** The simulator reports once a second; after this time (ms) its last report counts no more. */
const SIM_SILENT_AFTER = 2500;

const WARNING_SHOWN_FOR = 3000; // ms
const LOG_LINES = 12;

export class StatusView {
  constructor() {
    /** @type {any} */
    this._sim = null;
    this._simHeard = -Infinity;
    this._warnedAt = -Infinity;
    this._lastLogged = { sentence: "", at: -Infinity };
    /** What each node complained of last. @type {Map<string, string>} */
    this._complaints = new Map();
  }

  /** Whether the simulator says that the e-stop is active. */
  get estopped() {
    return this._sim?.e_stop === true;
  }

  /** @param {any} status  telex_msgs/SimStatus */
  setSim(status) {
    const before = this._sim;
    this._sim = status;
    this._simHeard = performance.now();
    if (before !== null && before.e_stop !== status.e_stop) {
      this.log(status.e_stop ? "e-stop is active" : "e-stop is released", status.e_stop);
    }
    this.logComplaint("simulator", (status.warnings ?? []).join("; "));
    this.showSim();
  }

  /** What the simulator said before the connection was lost counts no more. */
  forgetSim() {
    this._simHeard = -Infinity;
    this.showSim();
  }

  showSim() {
    const silent = performance.now() - this._simHeard > SIM_SILENT_AFTER;
    const { paused = false, real_time_factor: factor = 0 } = this._sim ?? {};
    const state = silent ? "silent" : paused ? "paused" : "running";
    byId("sim-state").dataset.state = state;
    byId("sim-state").textContent = { silent: "NO STATUS", paused: "PAUSED", running: "running" }[state];
    byId("sim-speed").textContent = silent || factor === null ? "–" : `${factor.toFixed(2)}×`;
    document.body.classList.toggle("estopped", this.estopped);
    byId("estop-band").hidden = !this.estopped;
    byId("release").hidden = !this.estopped;
  }

  /** @param {import("./bridge.js").Bridge} bridge */
  showLink(bridge) {
    const silent = bridge.connected && bridge.silence > SILENT_AFTER;
    document.body.classList.toggle("offline", !bridge.connected || silent);
    byId("link").dataset.state = silent ? "silent" : bridge.connected ? "up" : "lost";
    byId("link-band").hidden = bridge.connected && !silent;
    if (!bridge.connected) {
      byId("link-text").textContent = "not connected";
    } else if (silent) {
      byId("link-text").textContent = `silent ${(bridge.silence / 1000).toFixed(1)} s`;
      byId("link-band").textContent = "The robot does not answer. Everything is released.";
    } else {
      const trip = bridge.roundTrip === null ? "" : ` ${Math.max(1, Math.round(bridge.roundTrip))} ms`;
      byId("link-text").textContent = `connected${trip}`;
    }
  }

  /** @param {string} sentence */
  setLinkBand(sentence) {
    byId("link-band").textContent = sentence;
  }

  /** @param {number[]} speeds  Speed scales of the teleop nodes. */
  showSpeed(speeds) {
    const percent = speeds.map((speed) => Math.round(speed * 100));
    byId("speed").textContent =
      percent.length === 0 ? "–" : percent.length === 1 ? `${percent[0]} %` : `${percent[0]}–${percent.at(-1)} %`;
  }

  /** @param {import("./video.js").VideoView} video */
  showVideo(video) {
    const paused = this._sim?.paused === true;
    byId("view").dataset.state = video.live ? "live" : "stalled";
    const age = video.latency === null ? "" : ` · ${Math.max(0, Math.round(video.latency))} ms`;
    byId("camera-rate").textContent = video.live ? `${video.rate.toFixed(0)} fps${age}` : "";
    if (video.live) return;
    const since = Number.isFinite(video.age) ? ` for ${(video.age / 1000).toFixed(1)} s` : "";
    byId("no-picture-why").textContent = paused ? `the simulation is paused${since}` : `${video.trouble}${since}`;
  }

  /** Show a sentence over the picture for a while, and log it. @param {string} sentence */
  warn(sentence) {
    byId("warning").textContent = sentence;
    this._warnedAt = performance.now();
    this.log(sentence, true);
  }

  /** Let old warnings vanish. */
  fade() {
    if (performance.now() - this._warnedAt > WARNING_SHOWN_FOR) byId("warning").textContent = "";
  }

  /**
   * Log what a node complains of, whenever that changes.
   * @param {string} node
   * @param {string} sentence  Empty if it complains of nothing.
   */
  logComplaint(node, sentence) {
    if (this._complaints.get(node) === sentence) return;
    this._complaints.set(node, sentence);
    if (sentence) this.log(`${node}: ${sentence}`, true);
  }

  /**
   * @param {string} sentence
   * @param {boolean} [alarm]
   */
  log(sentence, alarm = false) {
    const now = performance.now();
    const repeated = sentence === this._lastLogged.sentence && now - this._lastLogged.at < 5000;
    this._lastLogged = { sentence, at: repeated ? this._lastLogged.at : now };
    if (repeated) return;
    const line = document.createElement("li");
    line.className = alarm ? "alarm" : "";
    const time = document.createElement("span");
    time.className = "num";
    time.textContent = new Date().toTimeString().slice(0, 8);
    line.append(time, sentence);
    line.title = sentence;
    const log = byId("log");
    log.prepend(line);
    while (log.childElementCount > LOG_LINES) log.lastElementChild?.remove();
  }
}
