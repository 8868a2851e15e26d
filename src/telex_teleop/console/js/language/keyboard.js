// @ts-check
/** What is printed on the keys of the user's keyboard: as the browser tells it, else as the user has chosen. */

import { storage } from "../storage.js";

/** By KeyboardEvent.code what is another sign than on a US keyboard. @typedef {Record<string, string>} Caps */

/** @type {Caps} */
const GERMAN_NAMES = { Space: "Leer", Backspace: "⌫", Home: "Pos1", End: "Ende", Insert: "Einfg", Delete: "Entf", PageUp: "Bild↑", PageDown: "Bild↓" };
/** @type {Caps} */
const QWERTZ = { KeyY: "Z", KeyZ: "Y", Slash: "-", IntlBackslash: "<" };

/** @type {Record<string, {name: string, caps: Caps, names: Caps}>} */
const LAYOUTS = {
  us: { name: "English (US)", caps: {}, names: {} },
  uk: { name: "English (UK)", caps: { Backslash: "#", IntlBackslash: "\\" }, names: {} },
  de: {
    name: "Deutsch (QWERTZ)",
    caps: {
      ...QWERTZ, Backquote: "^", Minus: "ß", Equal: "´", BracketLeft: "Ü", BracketRight: "+", Semicolon: "Ö", Quote: "Ä", Backslash: "#",
    },
    names: GERMAN_NAMES,
  },
  fr: {
    name: "Français (AZERTY)",
    caps: {
      KeyQ: "A", KeyA: "Q", KeyW: "Z", KeyZ: "W", Semicolon: "M", KeyM: ",", Comma: ";", Period: ":", Slash: "!", Quote: "Ù", Backslash: "*",
      BracketLeft: "^", BracketRight: "$", Minus: ")", Equal: "=", Backquote: "²", IntlBackslash: "<",
    },
    names: { Escape: "Échap", Space: "Espace", Enter: "Entrée", Backspace: "⌫", Home: "↖", End: "Fin", Insert: "Inser", Delete: "Suppr", PageUp: "Page↑", PageDown: "Page↓" },
  },
  ch: {
    name: "Schweiz, Suisse (QWERTZ)",
    caps: {
      ...QWERTZ, Backquote: "§", Minus: "'", Equal: "^", BracketLeft: "Ü", BracketRight: "¨", Semicolon: "Ö", Quote: "Ä", Backslash: "$",
    },
    names: {},
  },
};

const STORED_AS = "telex.keyboard";

/** The layout that goes with what the browser speaks, until somebody chooses another one. @param {readonly string[]} languages */
export function usualLayout([first = ""]) {
  const [speech, country] = first.toLowerCase().split("-");
  if (country === "ch") return "ch";
  if (country === "gb") return "uk";
  return speech === "de" || speech === "fr" ? speech : "us";
}

/** A capital where there is one: ß has none. @param {string | undefined} sign */
const printed = (sign) => (sign?.toUpperCase().length === 1 ? sign.toUpperCase() : sign);

/**
 * What is printed on a key; undefined: as on a US keyboard.
 * @param {ReadonlyMap<string, string>} told  What the browser says that keys type; empty: it says nothing.
 * @param {string} chosen  Name of a layout, where the browser says nothing.
 * @returns {(code: string) => string | undefined}
 */
export function capsOf(told, chosen) {
  const says = (/** @type {[string, string]} */ [code, cap]) => printed(told.get(code)) === cap;
  const layout = told.size === 0 ? LAYOUTS[chosen] ?? LAYOUTS.us : Object.values(LAYOUTS).find(({ caps }) => Object.keys(caps).length > 0 && Object.entries(caps).every(says));
  return (code) => {
    // Its figure is printed on every such key, whatever it types without Shift.
    if (code.startsWith("Digit")) return undefined;
    const cap = told.size === 0 ? layout?.caps[code] : told.get(code);
    // What asks for the keys is called by its question mark where the key has one.
    if (code === "Slash" && cap === "/") return undefined;
    return printed(cap) ?? layout?.names[code];
  };
}

/** What the browser says that keys type; empty where it does not tell. @returns {Promise<ReadonlyMap<string, string>>} */
async function toldLayout() {
  try {
    return await /** @type {any} */ (navigator).keyboard.getLayoutMap();
  } catch {
    return new Map();
  }
}

function chosenLayout() {
  const kept = storage.getItem(STORED_AS);
  return kept !== null && Object.hasOwn(LAYOUTS, kept) ? kept : usualLayout(navigator.languages ?? []);
}

/** What is printed on the keys now. */
export async function printedKeys() {
  return capsOf(await toldLayout(), chosenLayout());
}

/**
 * Let the user say which keyboard it is, where the browser does not.
 * @param {HTMLSelectElement} choice
 * @param {() => void} relabel  Shows the keys on the page anew.
 */
export async function offerLayouts(choice, relabel) {
  choice.replaceChildren(...Object.entries(LAYOUTS).map(([code, { name }]) => new Option(name, code)));
  choice.value = chosenLayout();
  choice.addEventListener("change", () => {
    storage.setItem(STORED_AS, choice.value);
    choice.blur(); // keys are the robot's again
    relabel();
  });
  /** @type {HTMLElement} */ (choice.parentElement).hidden = (await toldLayout()).size > 0;
}
