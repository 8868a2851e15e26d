// @ts-check
/** Header, bands over the picture, warnings and the log of messages. */

import { decimal, text } from "./language.js";
import { Messages } from "./messages.js";
import { byId, setText } from "./panels.js";

/** @typedef {import("./messages.js").Level} Level */

/** Time (ms) without a message after which the link counts as silent. */
export const SILENT_AFTER = 1000;

/** The simulator reports once a second; after this time (ms) its last report counts no more. */
const SIM_SILENT_AFTER = 2500;

const WARNING_SHOWN_FOR = 3000; // ms

export class StatusView {
  constructor() {
    this._messages = new Messages();
    /** @type {any} */
    this._sim = null;
    this._simHeard = -Infinity;
    this._warnedAt = -Infinity;
  }

  /** Whether the simulator says that the e-stop is active. */
  get estopped() {
    return this._sim?.e_stop === true;
  }

  /** Whether the simulator says that it is paused. */
  get paused() {
    return this._sim?.paused === true;
  }

  /** Whether the simulator says, not too long ago, that the robot is stuck. */
  get stuck() {
    return !this._isSilent && this._sim?.stuck === true;
  }

  get _isSilent() {
    return performance.now() - this._simHeard > SIM_SILENT_AFTER;
  }

  /** Whether another scene was loaded since the last word. @param {any} status  telex_msgs/SimStatus */
  isOtherWorld({ world }) {
    return this._sim !== null && this._sim.world !== world;
  }

  /** @param {any} status  telex_msgs/SimStatus */
  setSim(status) {
    const before = this._sim;
    this._sim = status;
    this._simHeard = performance.now();
    if (before !== null && before.e_stop !== status.e_stop) {
      this.log(status.e_stop ? text("e-stop is active") : text("e-stop is released"), status.e_stop ? "alarm" : "info");
    }
    if (before !== null && before.tipped_over !== status.tipped_over) {
      this.log(status.tipped_over ? text("the robot has tipped over") : text("the robot is upright again"), status.tipped_over ? "alarm" : "info");
    }
    if (before !== null && before.paused !== status.paused) {
      this.log(status.paused ? text("the simulation is paused") : text("the simulation goes on"));
    }
    this.logComplaint("simulator", (status.warnings ?? []).join("; "));
    this.showSim();
  }

  /** Discard the simulator's last report: the connection is lost. */
  forgetSim() {
    this._simHeard = -Infinity;
    this.showSim();
  }

  showSim() {
    const silent = this._isSilent;
    const { paused = false, real_time_factor: factor = 0 } = this._sim ?? {};
    const state = silent ? "silent" : paused ? "paused" : "running";
    byId("sim-state").dataset.state = state;
    setText(byId("sim-state"), { silent: text("NO STATUS"), paused: text("PAUSED"), running: text("running") }[state]);
    setText(byId("sim-speed"), silent || factor === null ? "–" : `${decimal(factor, 2)}×`);
    document.body.classList.toggle("estopped", this.estopped);
    byId("estop-band").hidden = !this.estopped;
    byId("release").hidden = !this.estopped;
  }

  /**
   * @param {import("./bridge.js").Bridge} bridge
   * @param {import("./line.js").Line} line
   */
  showLink(bridge, line) {
    const silent = bridge.connected && bridge.silence > SILENT_AFTER;
    document.body.classList.toggle("offline", !bridge.connected || silent);
    byId("link").dataset.state = silent ? "silent" : bridge.connected ? "up" : "lost";
    byId("link-band").hidden = bridge.connected && !silent;
    if (!bridge.connected) {
      setText(byId("link-text"), text("not connected"));
    } else if (silent) {
      setText(byId("link-text"), text("silent {seconds} s", { seconds: decimal(bridge.silence / 1000, 1) }));
      setText(byId("link-band"), line.silent(bridge.silence));
    } else {
      const trip = bridge.roundTrip === null ? "–" : `${Math.max(1, Math.round(bridge.roundTrip))} ms`;
      setText(byId("link-text"), text("connected {trip}", { trip }));
    }
  }

  /** @param {string} sentence */
  setLinkBand(sentence) {
    setText(byId("link-band"), sentence);
  }

  /** @param {number[]} speeds  Speed scales of the teleop nodes. */
  showSpeed(speeds) {
    const percent = speeds.map((speed) => Math.round(speed * 100));
    setText(byId("speed"), percent.length === 0 ? "–" : percent.length === 1 ? `${percent[0]} %` : `${percent[0]}–${percent.at(-1)} %`);
  }

  /**
   * @param {import("./cameras.js").Cameras} cameras
   * @param {boolean} isReduced  Whether pictures are smaller than the camera's own.
   */
  showVideo(cameras, isReduced) {
    const { main: video } = cameras;
    byId("view").dataset.state = video.live ? "live" : "stalled";
    const age = video.latency === null ? "" : ` · ${Math.max(0, Math.round(video.latency))} ms`;
    const news = cameras.awaitsScene ? text("drawing the new scene") : "";
    setText(byId("camera-rate"), video.live ? news || text("{rate} fps", { rate: video.rate.toFixed(0) }) + age : "");
    setText(byId("picture-size"), video.live && isReduced ? text("smaller pictures: the machine is busy") : "");
    if (video.live) return;
    const since = Number.isFinite(video.age) ? text(" for {seconds} s", { seconds: decimal(video.age / 1000, 1) }) : "";
    const why = news || (this.paused ? text("the simulation is paused") : video.trouble);
    setText(byId("no-picture-why"), `${why}${since}`);
  }

  /**
   * Show a sentence over the picture for a while, and log it.
   * @param {string} sentence
   * @param {Level} [level]
   */
  warn(sentence, level = "warning") {
    setText(byId("warning"), sentence);
    this._warnedAt = performance.now();
    this.log(sentence, level);
  }

  /** Remove old warnings, and log the complaints of the nodes. */
  fade() {
    if (performance.now() - this._warnedAt > WARNING_SHOWN_FOR) setText(byId("warning"), "");
    // A complaint that follows from a state the simulator reports is not logged again.
    this._messages.settle((sentence) =>
      (this.estopped && /\be-stop\b/.test(sentence)) || (this.paused && /\bpaused\b/.test(sentence)));
  }

  /**
   * Log what a node complains of, whenever that changes.
   * @param {string} node
   * @param {string} sentence  Empty if it complains of nothing.
   */
  logComplaint(node, sentence) {
    this._messages.complain(node, sentence);
  }

  /**
   * @param {string} sentence
   * @param {Level} [level]
   */
  log(sentence, level = "info") {
    this._messages.add(sentence, level);
  }
}
