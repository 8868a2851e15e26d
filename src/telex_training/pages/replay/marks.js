// @ts-check
/** What the timeline shows of a trial: texts, colours and shapes, without a page. */

import { decimal, term, text, translated } from "./language.js";

/** @typedef {{time: number, kind: string, event: string, name: string, detail: any}} Mark */
/** @typedef {{low: (number | null)[], high: (number | null)[]}} Envelope */

/** Kinds of marks, their colours, and their heights on the timeline. */
export const KINDS = /** @type {Record<string, {color: string, text: string, top: number}>} */ ({
  begin: { color: "#6ea3d4", text: term("begin"), top: 0 },
  step: { color: "#5fbf77", text: term("step"), top: 0.1 },
  fault: { color: "#ef5b52", text: term("fault or penalty"), top: 0 },
  contact: { color: "#f0a040", text: term("contact"), top: 0.45 },
  repetition: { color: "#6ea3d4", text: term("repetition"), top: 0 },
  stop: { color: "#e070d0", text: term("stop"), top: 0.3 },
  malfunction: { color: "#d8c840", text: term("malfunction"), top: 0.2 },
  invalid: { color: "#ef5b52", text: term("not valid"), top: 0 },
  note: { color: "#ffffff", text: term("note"), top: 0.2 },
  other: { color: "#7b8894", text: term("other"), top: 0.7 },
  end: { color: "#6ea3d4", text: term("end"), top: 0 },
});

/** Kinds of stretches and their colours. */
export const STRETCHES = /** @type {Record<string, string>} */ ({ slow: "#8a7420", stopped: "#7d2f74", paused: "#3a444d" });

const EVENTS = /** @type {Record<string, string>} */ ({
  begin: term("the clock starts"), step: term("step done"), fault: term("fault"), penalty: term("penalty"), contact: term("touched"), drop: term("dropped"), tipped: term("tipped over"),
  repetition: term("repetition"), practised: term("practice only"), bookmark: term("bookmark"), back: term("back to"), e_stop: term("emergency stop"), stuck: term("stuck"), invalid: term("not valid"), note: term("note"), mark: term("instructor's mark"), answer: term("answered"),
  camera: term("camera switched"), mode: term("mode switched"), end: term("end"), released: term("keys let go"),
  malfunction: term("malfunction"), mended: term("works again"), reaction: term("reaction"),
});

/** @param {Mark} mark */
export function sentence(mark) {
  const { event, name, detail } = mark;
  if (event === "moment") return `${name}${detail?.instructor && name !== "instructor" ? text(" (instructor)") : ""}: ${detail?.text ?? ""}`;
  const about = event === "note" ? detail?.text ?? "" : translated(name);
  const force = event === "contact" && typeof detail?.force === "number" ? `, ${Math.round(detail.force)} N` : "";
  const how = detail?.by === "e_stop" ? text("emergency stop") : text("other command");
  const reaction = event === "reaction" && typeof detail?.seconds === "number" ? text(", {how} after {seconds} s", { how, seconds: decimal(detail.seconds, 2) }) : "";
  return `${text(EVENTS[event] ?? event)}${about ? text(": |joint") + about : ""}${force}${reaction}`;
}

/** @param {number} seconds */
export function clock(seconds) {
  const hundredths = Math.round(100 * Math.max(0, seconds));
  const whole = Math.floor(hundredths / 100);
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}.${String(hundredths % 100).padStart(2, "0")}`;
}

/**
 * Largest value of a strip, rounded up to 1, 2 or 5 times a power of ten; 1 of an empty one.
 * @param {(number | null)[]} values
 */
export function ceiling(values) {
  const most = values.reduce((/** @type {number} */ found, value) => (value === null ? found : Math.max(found, value)), 0);
  if (most <= 0) return 1;
  const power = 10 ** Math.floor(Math.log10(most));
  const factor = [1, 2, 5, 10].find((each) => each * power >= most * (1 - 1e-9)) ?? 10;
  return factor * power;
}

/**
 * Outline of an envelope in a box of its bins' number by 1, y downwards: one closed path for each run of bins that have values.
 * @param {Envelope} envelope @param {number} top
 */
export function outline(envelope, top) {
  const { low, high } = envelope;
  const level = (/** @type {number} */ value) => (1 - Math.min(Math.max(value / top, 0), 1)).toFixed(3);
  const parts = [];
  for (let first = 0; first < high.length; first += 1) {
    if (high[first] === null) continue;
    let last = first;
    while (last + 1 < high.length && high[last + 1] !== null) last += 1;
    let path = "";
    for (let bin = first; bin <= last; bin += 1) path += `${path ? "L" : "M"}${bin} ${level(high[bin] ?? 0)}L${bin + 1} ${level(high[bin] ?? 0)}`;
    for (let bin = last; bin >= first; bin -= 1) path += `L${bin + 1} ${level(low[bin] ?? 0)}L${bin} ${level(low[bin] ?? 0)}`;
    parts.push(`${path}Z`);
    first = last;
  }
  return parts.join("");
}

/**
 * Number of the last mark that is not after a time; -1 before the first.
 * @param {Mark[]} marks @param {number} time
 */
export function current(marks, time) {
  let found = -1;
  marks.forEach((mark, number) => { if (mark.time <= time + 1e-3) found = number; });
  return found;
}
