// @ts-check
/** What exercises say, in the language that is shown. */

import { addTexts, decimal, language, onLanguage, term, text, translated } from "../language.js";

/** Where the station's texts are to be had; null: nobody has wanted them. @type {string | null} */
let place = null;
/** The language in which they were asked for last. */
let asked = "en";

/**
 * Bring what the station's exercises say in other languages by their own files, once another one than English is shown; they are shown
 * as if the language had changed.
 * @param {string} address
 */
export async function bringTexts(address) {
  if (place === null) onLanguage(() => asked !== language().code && ask());
  place = address;
  await ask();
}

async function ask() {
  asked = language().code;
  if (asked === "en" || place === null) return;
  try {
    const reply = await fetch(place, { cache: "no-store" });
    if (reply.ok) addTexts(await reply.json());
  } catch {
    // They are said in English then.
  }
}

/**
 * A sentence in parts: English with values in braces. What follows a bar is not said, and tells apart what other languages say in other words.
 * @typedef {{english: string, values: Record<string, any>}} Told  A value is a number, a text, or told itself.
 */

/** @param {Told} sentence @returns {string} */
export function told({ english, values }) {
  const say = (/** @type {any} */ value) => (typeof value === "number" ? decimal(value, 4, 0) : typeof value === "string" ? text(value) : told(value));
  return text(english, Object.fromEntries(Object.entries(values).map(([name, value]) => [name, say(value)])));
}

/** The texts among a sentence's values. @param {Told} sentence @returns {string[]} */
const textsIn = ({ values }) => Object.values(values).flatMap((value) => (typeof value === "string" ? [value] : typeof value === "number" ? [] : textsIn(value)));

/** What the zones of sentences are called, beside their names in pictures; empty in English. @param {Told[]} sentences */
export function zonesOf(sentences) {
  const zones = [...new Set(sentences.flatMap(textsIn))].filter((value) => value.endsWith("|zone"));
  const named = zones.map((zone) => [zone.split("|")[0], text(zone).replaceAll("\u2060", "")]).filter(([name, own]) => name !== own);
  return named.map(([name, own]) => ` ${name} = ${own}`).join(",");
}

/** What a metric measures, and of which object or robot. @param {string} sentence @returns {string} */
export function metricText(sentence) {
  const cut = sentence.lastIndexOf(", ");
  const whole = translated(sentence);
  if (whole !== sentence || cut < 0) return whole;
  return `${metricText(sentence.slice(0, cut))}, ${text(`${sentence.slice(cut + 2)}|name`)}`;
}

/** Where the ring of a chart is open. */
const DIRECTIONS = [
  term("right|choice"), term("up right|choice"), term("up|choice"), term("up left|choice"), term("left|choice"), term("down left|choice"),
  term("down|choice"), term("down right|choice"),
];

/** @param {string} choice  An answer to a question. */
export const choiceText = (choice) => text(`${choice}|choice`);

/** What somebody has typed, with the directions in it as the judge knows them. @param {string} words */
export function answerOf(words) {
  const plain = (/** @type {string} */ part) => part.replaceAll("\u2060", "").trim().toLowerCase();
  const known = (/** @type {string} */ part) => DIRECTIONS.find((each) => plain(text(each)) === plain(part))?.split("|")[0];
  return words.split(/[,;]/).map((part) => known(part) ?? part.trim()).join(", ");
}
