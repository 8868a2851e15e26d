// @ts-check
/** How the robot stands and how far it is from tipping over, over the picture. */

import { term, text } from "./language.js";
import { byId, setText } from "./panels.js";

export const STABILITY = { topic: "sim/stability", type: "telex_msgs/Stability" };

/** Time (ms) without a word after which the display shows nothing any more. */
const SILENT_AFTER = 1000;

/** By telex_msgs/Stability.state. */
const STATES = [
  { name: "stable", word: term("stable") },
  { name: "caution", word: term("CAUTION") },
  { name: "critical", word: term("TIPPING") },
  { name: "tipped", word: term("TIPPED OVER") },
];

/** Counter-clockwise from the nose, an eighth of a turn each. */
const WAYS = [
  term("over the front"), term("over the front left"), term("over the left"), term("over the rear left"),
  term("over the rear"), term("over the rear right"), term("over the right"), term("over the front right"),
];

const PANEL = `
  <div class="attitude-views" id="attitude-views" role="img">
    <div>
      <svg viewBox="-50 -30 100 60" aria-hidden="true">
        <path class="ground" d="M-50 14H50"/>
        <g id="attitude-side">
          <rect class="belt" x="-38" y="-3" width="76" height="17" rx="8.5"/>
          <path class="robot" d="M-30 -4v-8h60l4 8z M8 -12v-4h-24v-5h34v9z"/>
        </g>
      </svg>
      <span class="num" id="attitude-pitch"></span>
    </div>
    <div>
      <svg viewBox="-50 -30 100 60" aria-hidden="true">
        <path class="ground" d="M-50 14H50"/>
        <g id="attitude-rear">
          <rect class="belt" x="-28" y="-5" width="9" height="19" rx="3"/>
          <rect class="belt" x="19" y="-5" width="9" height="19" rx="3"/>
          <path class="robot" d="M-18 -11h36v19h-36z M-7 -11v-9h14v9z"/>
        </g>
      </svg>
      <span class="num" id="attitude-roll"></span>
    </div>
  </div>
  <div class="attitude-line">
    <b id="attitude-word" role="status"></b>
    <span><span id="attitude-way"></span> <span class="num" id="attitude-margin"></span></span>
  </div>
  <div class="attitude-meter" id="attitude-meter" role="meter" aria-valuemin="0" aria-valuemax="100" aria-valuenow="0">
    <i id="attitude-fill"></i>
  </div>
`;

export class AttitudeView {
  /** @param {(sentence: string) => void} warn  Told when the robot begins to tip over. */
  constructor(warn) {
    byId("attitude").innerHTML = PANEL;
    byId("attitude-meter").setAttribute("aria-label", text("Margin before it tips over"));
    this._warn = warn;
    this._heard = -Infinity;
    this._show("silent");
  }

  /** Whether the robot tips over, or has. */
  get isTipping() {
    return ["critical", "tipped"].includes(byId("attitude").dataset.state ?? "");
  }

  /** @param {any} stability  telex_msgs/Stability */
  set(stability) {
    this._heard = performance.now();
    const { name, word } = STATES[stability.state] ?? STATES[0];
    const percent = Math.max(0, Math.round(100 * (stability.margin ?? 0)));
    // A robot that nothing supports has no edge to tip over.
    const isCarried = (stability.support ?? []).length >= 2 && Number.isFinite(stability.direction);
    const way = isCarried ? text(WAYS[Math.round((4 * stability.direction) / Math.PI + 8) % 8]) : "";
    // How little is left to tip does not follow from the margin then, which may be ample still.
    const isTipping = name === "critical";
    const share = isTipping || !Number.isFinite(stability.margin) ? "" : `${percent} %`;
    const tipping = way === "" ? text("about to tip over") : text("about to tip {way}", { way });
    if (isTipping && byId("attitude").dataset.state !== name) this._warn(tipping);
    const pitch = describe(stability.pitch, text("nose down"), text("nose up"));
    const roll = describe(stability.roll, text("right down"), text("left down"));
    turn("attitude-side", stability.pitch);
    turn("attitude-rear", stability.roll);
    setText(byId("attitude-pitch"), pitch);
    setText(byId("attitude-roll"), roll);
    const full = isTipping ? 0 : Math.min(100, percent);
    byId("attitude-fill").style.width = `${full}%`;
    setText(byId("attitude-margin"), share);
    setText(byId("attitude-way"), way !== "" && (name === "caution" || isTipping) ? way : "");
    const meter = byId("attitude-meter");
    meter.setAttribute("aria-valuenow", String(full));
    const weakest = way === "" ? "" : text(", weakest {way}", { way });
    meter.setAttribute("aria-valuetext", isTipping ? tipping : share === "" ? text("not known") : text("{percent} percent", { percent }) + weakest);
    this._show(name, text(word));
    byId("attitude-views").setAttribute("aria-label", text("Attitude: {pitch}, {roll}", { pitch, roll }));
  }

  /** Show nothing rather than what was true a while ago. */
  fade() {
    if (performance.now() - this._heard > SILENT_AFTER) this._show("silent");
  }

  /**
   * @param {string} name
   * @param {string} [word]
   */
  _show(name, word = "") {
    const panel = byId("attitude");
    if (panel.dataset.state === name) return;
    panel.dataset.state = name;
    panel.hidden = name === "silent";
    setText(byId("attitude-word"), word);
  }
}

/**
 * @param {number | null} angle  rad; null is what the bridge makes of a figure that is none
 * @param {string} positive
 * @param {string} negative
 */
function describe(angle, positive, negative) {
  if (angle === null) return "–";
  const degrees = Math.round((angle * 180) / Math.PI);
  if (degrees === 0) return text("level");
  return `${Math.abs(degrees)}° ${degrees > 0 ? positive : negative}`;
}

/**
 * @param {string} id
 * @param {number | null} angle  rad, clockwise
 */
function turn(id, angle) {
  byId(id).setAttribute("transform", `rotate(${(((angle ?? 0) * 180) / Math.PI).toFixed(1)})`);
}
