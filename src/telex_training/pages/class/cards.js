// @ts-check
/** A card for each station: who does what, and how far. */

import { element } from "../elements.js";
import { text, translated } from "../replay/language.js";

/**
 * @typedef {object} Station  As /class/api/state has it; times are so many seconds ago.
 * @property {string} name
 * @property {"connecting" | "here" | "gone"} phase
 * @property {number} since
 * @property {number} age
 * @property {string} reason
 * @property {State | null} state
 * @property {{title: string, setting: string, operator: string, valid: boolean, verdict: string} | null} last
 * @property {number | null} picture
 * @property {number | null} picture_age
 * @property {{what: string, done: boolean, ok: boolean, text: string} | null} order
 *
 * @typedef {object} State
 * @property {string} phase
 * @property {string} title
 * @property {string} setting
 * @property {string} mode
 * @property {string} operator
 * @property {string} holder
 * @property {boolean} valid
 * @property {number} repetition
 * @property {number} repetitions
 * @property {string[]} results
 * @property {number} elapsed
 * @property {number} penalty
 * @property {string[]} steps
 * @property {boolean[]} steps_done
 * @property {string[]} faults
 * @property {string} message
 * @property {string} verdict
 * @property {number | null} help
 */

const LATE = 3; // s after which an answer, or a picture, is said to be old
const LATE_PICTURE = 5;

/** @param {number} seconds */
export function ago(seconds) {
  const whole = Math.max(0, Math.round(seconds));
  if (whole < 60) return `${whole} s`;
  return whole < 3600 ? `${Math.floor(whole / 60)} min ${whole % 60} s` : `${Math.floor(whole / 3600)} h ${Math.floor((whole % 3600) / 60)} min`;
}

/** Time of day so many seconds ago. @param {number} seconds */
function at(seconds) {
  return new Date(Date.now() - 1000 * seconds).toLocaleTimeString("en-GB");
}

/** Whether it is there, and if not, since when. @param {Station} station */
export function standingText({ phase, since, age, state }) {
  if (phase === "connecting") return text("connecting …");
  if (phase === "gone") return state === null ? text("NOT REACHED since {time} ({age})", { time: at(since), age: ago(since) }) : text("GONE since {time} ({age})", { time: at(since), age: ago(since) });
  return age > LATE ? text("no answer for {age}", { age: ago(age) }) : "";
}

/** Who sits there: whose trial it is, and who has control if that is another one. @param {State} state */
export function whoText({ operator, holder }) {
  const others = holder !== "" && holder !== operator ? text("control: {name}", { name: holder }) : "";
  return [operator, others].filter(Boolean).join(" · ") || text("nobody");
}

/** @param {{title: string, setting: string, mode?: string}} state */
export function whatText({ title, setting, mode }) {
  return [translated(title), setting === "standard" ? "" : translated(setting), mode === "exam" ? text("EXAM") : translated(mode ?? "")].filter(Boolean).join(" · ");
}

/** Phase, repetition and clock. @param {State} state */
export function clockText({ phase, repetition, repetitions, results, elapsed, penalty }) {
  if (phase === "idle") return text("no exercise is open");
  const seconds = Math.max(0, Math.floor(elapsed + penalty));
  const clock = phase === "running" ? `${String(Math.floor(seconds / 60)).padStart(2, "0")}:${String(seconds % 60).padStart(2, "0")}` : "";
  const count = repetition === 0 || phase === "ended" ? "" : repetitions > 0 ? text("repetition {count} of {all}", { count: repetition, all: repetitions }) : text("repetition {count}", { count: repetition });
  return [translated(phase), count, clock, results.slice(-12).map((result) => (result === "passed" ? "✔" : "✘")).join("")].filter(Boolean).join(" · ");
}

/** The step that is due. @param {State} state */
export function stepText({ phase, steps, steps_done: done }) {
  const next = steps.findIndex((_, index) => !done[index]);
  return !["waiting", "running"].includes(phase) || next < 0 ? "" : text("step {count}: {step}", { count: `${done.filter(Boolean).length + 1}/${steps.length}`, step: translated(steps[next]) });
}

/** Verdict of the trial that ended last. @param {Station["last"]} last */
export function lastText(last) {
  if (last === null) return "";
  const verdict = last.valid ? translated(last.verdict) || text("no verdict") : text("not valid");
  return text("last: {verdict} · {what} · {who}", { verdict, what: whatText(last), who: last.operator || text("no name") });
}

/** @param {Station["order"]} order */
export function orderText(order) {
  if (order === null) return "";
  if (!order.done) return `${translated(order.what)} …`;
  return order.ok ? text("{what}: done", { what: translated(order.what) }) : `${translated(order.what)}: ${translated(order.text)}`;
}

export class Card {
  /**
   * @param {string} name
   * @param {(path: string, more?: Record<string, string>) => string} address
   * @param {(name: string) => void} endHelp
   */
  constructor(name, address, endHelp) {
    this._name = name;
    this._address = address;
    /** Number of the picture that is shown. @type {number | null} */
    this._picture = null;
    /** @type {Record<string, HTMLElement>} */
    this._parts = {};
    const part = (/** @type {string} */ kind, /** @type {string} */ className, /** @type {Node[]} */ children = []) => {
      this._parts[className] = element(kind, "", { class: className }, children);
      return this._parts[className];
    };
    const link = element("a", name, { href: address(`station/${encodeURIComponent(name)}`), target: "_blank", rel: "noopener noreferrer", title: text("Opens the station's page for instructors") });
    const given = element("button", text("done"), { type: "button", title: text("Help was given") });
    given.addEventListener("click", () => endHelp(name));
    this._image = /** @type {HTMLImageElement} */ (element("img", "", { alt: text("camera of {name}", { name }), hidden: "" }));
    const nothing = element("span", text("no picture"));
    const open = element("a", "", { class: "view", href: link.getAttribute("href") ?? "", target: "_blank", rel: "noopener noreferrer", title: text("Picture of {name}", { name }) }, [nothing, this._image, part("small", "picture-age")]);
    this._view = open;
    this.root = element("article", "", { class: "station", "data-station": name }, [
      element("h2", "", {}, [link, part("span", "standing")]),
      part("div", "reason"),
      part("div", "help", [element("span", "", { class: "help-text" }), given]),
      open,
      element("div", "", { class: "facts" }, ["who", "about", "clock", "step", "faults", "last"].map((each) => part("div", each))),
      part("div", "order"),
    ]);
    this._help = /** @type {HTMLElement} */ (this.root.querySelector(".help-text"));
    // The line must not grow as the picture does.
    this._image.addEventListener("load", () => {
      this._image.hidden = false;
      nothing.hidden = true;
    });
  }

  /** @param {Station} station @param {boolean} pictures */
  show(station, pictures) {
    const { state, phase } = station;
    this.root.dataset.phase = phase;
    const asks = state !== null && state.help !== null && phase === "here";
    this.root.dataset.help = String(asks);
    this._set("standing", standingText(station));
    this._set("reason", phase === "gone" ? translated(station.reason) : "");
    this._parts.help.hidden = !asks;
    const asked = asks ? text("{name} asks for help, for {age}", { name: state.operator || text("no name"), age: ago((state.help ?? 0) + station.age) }) : "";
    if (this._help.textContent !== asked) this._help.textContent = asked;
    this._set("who", state === null ? "" : whoText(state));
    this._set("about", state === null ? "" : whatText(state));
    this._set("clock", state === null ? "" : clockText(state));
    this._set("step", state === null ? "" : stepText(state));
    this._set("faults", state === null ? "" : [state.valid ? "" : text("NOT VALID"), ...state.faults.map(translated), translated(state.message)].filter(Boolean).join(" · "));
    this._set("last", lastText(station.last));
    this._set("order", orderText(station.order));
    this._parts.order.dataset.ok = String(station.order === null || !station.order.done || station.order.ok);
    this._view.hidden = !pictures;
    this._showPicture(station);
  }

  /** @param {Station} station */
  _showPicture({ picture, picture_age: age }) {
    if (picture !== null && picture !== this._picture && !this._view.hidden) {
      this._picture = picture;
      this._image.src = this._address(`api/picture/${encodeURIComponent(this._name)}`, { n: String(picture) });
    }
    this._set("picture-age", age !== null && age > LATE_PICTURE ? text("{age} old", { age: ago(age) }) : "");
  }

  /** @param {string} part @param {string} words */
  _set(part, words) {
    if (this._parts[part].textContent !== words) this._parts[part].textContent = words;
  }
}
