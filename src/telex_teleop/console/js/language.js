// @ts-check
/** The texts and figures of the pages in the language that is shown. */

import { DE } from "./language/de.js";
import { EXERCISES_DE } from "./language/exercises_de.js";
import { EXERCISES_FR } from "./language/exercises_fr.js";
import { FR } from "./language/fr.js";
import { term } from "./language/term.js";
import { storage } from "./storage.js";

export { term };

/** @typedef {"en" | "de" | "fr"} Language */

/** What each language calls itself, and its sentences by the English ones. @type {Record<Language, {name: string, table: Record<string, string>}>} */
const LANGUAGES = {
  en: { name: "English", table: {} },
  de: { name: "Deutsch", table: { ...DE, ...EXERCISES_DE } },
  fr: { name: "Français", table: { ...FR, ...EXERCISES_FR } },
};
const ORDER = /** @type {Language[]} */ (Object.keys(LANGUAGES));

const STORED_AS = "telex.language";
const REMEMBERED = 2000; // sentences with figures
const UNSEEN = "\u2060";

/** @typedef {Record<string, string | number>} Values */
/** @typedef {{english: string, values: Values}} Said */

/** What was said, by the sentence, for it to be said anew in another language. @type {Map<string, Said>} */
const said = new Map();

/** The newest of those with figures, which there is no end of. @type {Map<string, Said>} */
const figures = new Map();

/** The language that is shown. @type {Language} */
let shown = firstOf(globalThis.document === undefined ? [] : wishes());

/** Called after every change. @type {(() => void)[]} */
const changed = [];

/** Who is asked for a language, one after the other: the page's address, what was chosen before, the browser. */
function wishes() {
  return [new URLSearchParams(location.search).get("lang"), storage.getItem(STORED_AS), ...(navigator.languages ?? [])];
}

/** @param {(string | null)[]} asked @returns {Language} */
function firstOf(asked) {
  const codes = asked.map((each) => (each ?? "").toLowerCase().split("-")[0]);
  return /** @type {Language | undefined} */ (codes.find((code) => Object.hasOwn(LANGUAGES, code))) ?? "en";
}

/**
 * Translate what the page says.
 * @param {string} english  What is said in English, which is also its name in the tables of other languages; `{name}` stands for a value. What
 *   follows a bar is not said: it tells apart what only English says in the same words.
 * @param {Values} [values]
 * @returns {string}
 */
export function text(english, values = {}) {
  const { table } = LANGUAGES[shown];
  const words = Object.hasOwn(table, english) ? table[english] : english.split("|")[0];
  let sentence = words.replace(/\{(\w+)\}/g, (whole, name) => (name in values ? String(values[name]) : whole));
  // What two English sentences have in common in this language is told apart by what nobody sees.
  while ((remembered(sentence)?.english ?? english) !== english) sentence += UNSEEN;
  const memory = /\d/.test(sentence) ? figures : said;
  memory.delete(sentence);
  memory.set(sentence, { english, values });
  if (figures.size > REMEMBERED) figures.delete(/** @type {string} */ (figures.keys().next().value));
  return sentence;
}

/** What a sentence was made of; undefined: nobody has said it. @param {string} sentence @returns {Said | undefined} */
function remembered(sentence) {
  return said.get(sentence) ?? figures.get(sentence);
}

/**
 * Say in the language that is shown what this page has said in another one, or has in its markup.
 * @param {string} sentence  What nobody has said here, and is in no table, stays as it is.
 * @returns {string}
 */
export function again(sentence) {
  const known = remembered(sentence) ?? (isKnown(sentence) ? { english: sentence, values: {} } : undefined);
  return known === undefined ? sentence : anew(known, again);
}

/**
 * The same of what a server has said in English, whose figures and names are where the tables have values.
 * @param {string} sentence
 * @returns {string}
 */
export function translated(sentence) {
  const known = remembered(sentence) || isKnown(sentence) ? undefined : formOf(sentence);
  if (known !== undefined) return anew(known, translated);
  const [figure = "", number, unit] = FIGURE.exec(sentence) ?? [];
  if (figure !== "") return `${decimal(Number(number), number.split(".")[1].length)}${unit}`;
  if (NAMES.test(sentence)) return sentence.split(", ").map(translated).join(", ");
  const now = again(sentence);
  const joint = JOINTS.find((each) => sentence.includes(each.split("|")[0]));
  return now !== sentence || joint === undefined ? now : sentence.split(joint.split("|")[0]).map(translated).join(text(joint));
}

/** What servers put sentences together with. */
const JOINTS = [term("; |joint"), term(": |joint")];

/** A figure as a server writes it, with its unit or without. */
const FIGURE = /^(-?\d+\.\d+)((?: [^\s\d]+)?)$/;

/** Names one after the other, such as those of an exercise and its setting. */
const NAMES = /^\w+(?:, \w+)+$/;

/** Whether a language has it. @param {string} sentence */
function isKnown(sentence) {
  return Object.values(LANGUAGES).some(({ table }) => Object.hasOwn(table, sentence));
}

/** @param {Said} known  @param {(value: string) => string} say  Of its values. */
function anew({ english, values }, say) {
  return text(english, Object.fromEntries(Object.entries(values).map(([name, value]) => [name, typeof value === "string" ? say(value) : value])));
}

const LEAST_LETTERS = 3; // that tell a sentence with values from any other one

/** Sentences with values, and what they look like. @type {{english: string, names: string[], look: RegExp}[] | null} */
let forms = null;

/** The newest sentences that are none of them: names come again and again. @type {Set<string>} */
const formless = new Set();

/** How many letters it has beside its values. @param {string} english */
const lettersOf = (english) => english.replace(/\{\w+\}/g, "").match(/\p{L}/gu)?.length ?? 0;

/** A sentence with values that this one is; undefined: none. @param {string} sentence */
function formOf(sentence) {
  forms ??= Object.keys(DE)
    .filter((english) => english.includes("{") && lettersOf(english) >= LEAST_LETTERS)
    .sort((one, other) => lettersOf(other) - lettersOf(one)) // the most particular first
    .map((english) => ({
      english,
      names: [...english.matchAll(/\{(\w+)\}/g)].map(([, name]) => name),
      // A count is a number.
      look: new RegExp(`^${english.replace(/[.*+?^$()|[\]\\]/g, "\\$&").replace(/\{(\w+)\}/g, (_, name) => (name === "count" ? "(\\d+)" : "(.+?)"))}$`),
    }));
  if (formless.has(sentence)) return undefined;
  for (const { english, names, look } of forms) {
    const found = look.exec(sentence);
    if (found !== null) return { english, values: Object.fromEntries(names.map((name, index) => [name, found[index + 1]])) };
  }
  formless.add(sentence);
  if (formless.size > REMEMBERED) formless.delete(/** @type {string} */ (formless.values().next().value));
  return undefined;
}

/**
 * Take what exercises say in other languages by their own files; what pages say themselves stays as it is.
 * @param {Record<string, Record<string, string>>} tables  By codes of languages, and by the English texts.
 */
export function addTexts(tables) {
  let isNew = false;
  for (const [code, { table }] of Object.entries(LANGUAGES)) {
    const news = Object.entries(tables[code] ?? {}).filter(([english]) => code !== "en" && !Object.hasOwn(table, english));
    Object.assign(table, Object.fromEntries(news));
    isNew ||= news.length > 0;
  }
  if (isNew) for (const act of changed) act();
}

/** @type {Map<string, Intl.NumberFormat>} */
const formats = new Map();

/**
 * A figure as the language writes it, without "-0".
 * @param {number} value
 * @param {number} digits  After the point.
 * @param {number} [least]  So many of them also where they are zeros.
 */
export function decimal(value, digits, least = digits) {
  const key = `${shown} ${digits} ${least}`;
  let format = formats.get(key);
  if (format === undefined) {
    format = new Intl.NumberFormat(shown, { minimumFractionDigits: least, maximumFractionDigits: digits, useGrouping: false });
    formats.set(key, format);
  }
  return format.format(Number(value.toFixed(digits)) || 0);
}

/** The language that is shown, and what it calls itself. */
export const language = () => ({ code: shown, name: LANGUAGES[shown].name });

/** @param {() => void} act  Called when another language is shown. */
export function onLanguage(act) {
  changed.push(act);
}

/** Show the next language, and keep that choice. */
export function nextLanguage() {
  shown = ORDER[(ORDER.indexOf(shown) + 1) % ORDER.length];
  keep();
  for (const act of changed) act();
}

/** Keep the language for this browser's other pages, and for the next time. */
export function keep() {
  storage.setItem(STORED_AS, shown);
}
