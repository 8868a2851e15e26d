// @ts-check
/** The instructor's panel of the line between console and robot: one click for each profile. */

import { makeButton } from "../buttons.js";
import { decimal, term, text, translated } from "../language.js";
import { all, byId, check, setText } from "../panels.js";

/** Profiles of the shipped file, and how a button calls them. @type {[string, string, string][]} */
const PROFILES = [
  ["perfect", term("perfect"), term("nothing is impaired")],
  ["wifi", term("wifi"), term("a good wireless network with others on it")],
  ["150", "150", term("150 ms later each way")],
  ["300", "300", term("300 ms later each way")],
  ["500", "500", term("500 ms later each way")],
  ["1000", "1 s", term("a second later each way")],
  ["lossy", term("lossy"), term("a radio at the edge of its range")],
  ["by_distance", term("distance"), term("as the radio signal is where the robot stands")],
];

/** @typedef {import("../line.js").LinkState} LinkState */

/** Shown once somebody tells of a line. */
export class LinePanel {
  /** @param {import("../robot_client.js").RobotClient} robot */
  constructor(robot) {
    this._robot = robot;
    this._profile = "";
    this._offered = "";
  }

  /** @param {LinkState} state */
  hear(state) {
    byId("line-panel").hidden = false;
    this._profile = state.profile;
    setText(byId("line-note"), lineText(state));
    this._offer();
    check(all("button", byId("line-profiles")), ({ dataset }) => dataset.profile === this._profile);
  }

  /** Offer the shipped profiles, and the present one where it is another. */
  _offer() {
    const known = PROFILES.some(([name]) => name === this._profile);
    /** @type {[string, string, string][]} */
    const offered = known ? PROFILES : [...PROFILES, [this._profile, this._profile, term("as configured")]];
    const names = offered.map(([name]) => name).join();
    if (names === this._offered) return;
    this._offered = names;
    byId("line-profiles").replaceChildren(...offered.map(([name, label, title]) => {
      const button = makeButton(text(label), () => this._choose(name));
      button.title = text(title);
      button.dataset.profile = name;
      button.setAttribute("role", "radio");
      return button;
    }));
  }

  /** @param {string} profile */
  async _choose(profile) {
    if (profile === this._profile) return;
    const change = { profile, fields: "" };
    const changed = await this._robot.request("link/configure", change, (why) => text("line: {why}", { why }));
    if (changed) this._robot.log(text("line: {profile}", { profile: translated(profile) }));
  }
}

/**
 * What the line does to its traffic, in words.
 * @param {Pick<LinkState, "delay" | "jitter" | "loss" | "bandwidth" | "outage">} state
 */
export function lineText({ delay, jitter, loss, bandwidth, outage }) {
  if (outage) return text("nothing passes now");
  const parts = [];
  if (delay > 0 || jitter > 0) parts.push(`${Math.round(1000 * delay)}${jitter > 0 ? `–${Math.round(1000 * (delay + jitter))}` : ""} ms`);
  if (loss > 0) parts.push(text("{percent} % lost", { percent: decimal(100 * loss, 1, 0) }));
  if (bandwidth > 0) parts.push(`${decimal(bandwidth / 1e6, 1, 0)} Mbit/s`);
  return parts.join(", ") || text("nothing is impaired");
}
