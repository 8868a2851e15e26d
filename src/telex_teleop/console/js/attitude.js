// @ts-check
/** How the robot stands and how far it is from tipping over, over the picture. */

import { byId, setText } from "./panels.js";

export const STABILITY = { topic: "sim/stability", type: "telex_msgs/Stability" };

/** Time (ms) without a word after which the display shows nothing any more. */
const SILENT_AFTER = 1000;

/** By telex_msgs/Stability.state. */
const STATES = [
  { name: "stable", word: "stable" },
  { name: "caution", word: "CAUTION" },
  { name: "critical", word: "TIPPING" },
  { name: "tipped", word: "TIPPED OVER" },
];

/** Counter-clockwise from the nose, an eighth of a turn each. */
const WAYS = ["front", "front left", "left", "rear left", "rear", "rear right", "right", "front right"];

const PANEL = `
  <div class="attitude-views" id="attitude-views" role="img" aria-label="Attitude">
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
  <div class="attitude-meter" id="attitude-meter" role="meter" aria-label="Margin before it tips over" aria-valuemin="0" aria-valuemax="100" aria-valuenow="0">
    <i id="attitude-fill"></i>
  </div>
`;

export class AttitudeView {
  /** @param {(sentence: string) => void} warn  Told when the robot begins to tip over. */
  constructor(warn) {
    byId("attitude").innerHTML = PANEL;
    this._warn = warn;
    this._heard = -Infinity;
    this._show("silent");
  }

  /** @param {any} stability  telex_msgs/Stability */
  set(stability) {
    this._heard = performance.now();
    const { name, word } = STATES[stability.state] ?? STATES[0];
    const percent = Math.max(0, Math.round(100 * (stability.margin ?? 0)));
    // What nothing carries tips over no edge.
    const isCarried = (stability.support ?? []).length >= 2 && Number.isFinite(stability.direction);
    const way = isCarried ? WAYS[Math.round((4 * stability.direction) / Math.PI + 8) % 8] : "";
    // How little is left to tip does not follow from the margin then, which may be ample still.
    const isTipping = name === "critical";
    const share = isTipping || !Number.isFinite(stability.margin) ? "" : `${percent} %`;
    const tipping = way === "" ? "about to tip over" : `about to tip over the ${way}`;
    if (isTipping && byId("attitude").dataset.state !== name) this._warn(tipping);
    const pitch = describe(stability.pitch, "nose down", "nose up");
    const roll = describe(stability.roll, "right down", "left down");
    turn("attitude-side", stability.pitch);
    turn("attitude-rear", stability.roll);
    setText(byId("attitude-pitch"), pitch);
    setText(byId("attitude-roll"), roll);
    const full = isTipping ? 0 : Math.min(100, percent);
    byId("attitude-fill").style.width = `${full}%`;
    setText(byId("attitude-margin"), share);
    setText(byId("attitude-way"), way !== "" && (name === "caution" || isTipping) ? `over the ${way}` : "");
    const meter = byId("attitude-meter");
    meter.setAttribute("aria-valuenow", String(full));
    const weakest = way === "" ? "" : `, weakest over the ${way}`;
    meter.setAttribute("aria-valuetext", isTipping ? tipping : share === "" ? "not known" : `${percent} percent${weakest}`);
    this._show(name, word);
    byId("attitude-views").setAttribute("aria-label", `Attitude: ${pitch}, ${roll}`);
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
  if (degrees === 0) return "level";
  return `${Math.abs(degrees)}° ${degrees > 0 ? positive : negative}`;
}

/**
 * @param {string} id
 * @param {number | null} angle  rad, clockwise
 */
function turn(id, angle) {
  byId(id).setAttribute("transform", `rotate(${(((angle ?? 0) * 180) / Math.PI).toFixed(1)})`);
}
