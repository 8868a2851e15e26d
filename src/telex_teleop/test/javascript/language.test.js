import assert from "node:assert/strict";
import { test } from "node:test";

import { FakeStorage } from "./browser.js";
import { capsOf, usualLayout } from "../../console/js/language/keyboard.js";

const KEPT = "telex.language";
let loaded = 0;

/** The module anew, as a page has it. */
async function page(/** @type {{search?: string, kept?: string, languages?: string[]}} */ { search = "", kept = undefined, languages = ["en-GB"] } = {}) {
  const storage = new FakeStorage(kept === undefined ? {} : { [KEPT]: kept });
  Object.defineProperty(globalThis, "document", { value: {}, configurable: true });
  Object.defineProperty(globalThis, "location", { value: { search }, configurable: true });
  Object.defineProperty(globalThis, "localStorage", { value: storage, configurable: true });
  Object.defineProperty(globalThis, "navigator", { value: { languages }, configurable: true });
  loaded += 1;
  return { storage, ...(await import(`../../console/js/language.js?${loaded}`)) };
}

for (const [asked, code] of /** @type {[object, string][]} */ ([
  [{}, "en"],
  [{ languages: ["pt-BR", "fr-CA", "de"] }, "fr"],
  [{ languages: ["pt-BR"] }, "en"],
  [{ kept: "de", languages: ["fr"] }, "de"],
  [{ kept: "tlh", languages: ["fr"] }, "fr"],
  [{ search: "?lang=fr", kept: "de" }, "fr"],
  [{ search: "?lang=constructor", kept: "de" }, "de"],
])) {
  test(`${JSON.stringify(asked)} is answered in ${code}`, async () => {
    assert.equal((await page(asked)).language().code, code);
  });
}

test("sentences have their values, and what no table has stays English", async () => {
  const { text } = await page({ languages: ["de"] });
  assert.equal(text("{name} has control", { name: "Ann" }), "Ann hat die Steuerung");
  assert.equal(text("{name} says so", { name: "Ann" }), "Ann says so");
  assert.equal(text("end|deed"), "beheben");
  assert.equal((await page()).text("end|deed"), "end");
});

test("what was said is said anew in the next language, which is kept", async () => {
  const { text, again, nextLanguage, onLanguage, language, storage } = await page({ languages: ["de"] });
  let changes = 0;
  onLanguage(() => { changes += 1; });
  // In French both are one word.
  const said = [text("front"), text("ahead"), text("{name} has control", { name: text("somebody") })];
  nextLanguage();
  assert.equal(language().code, "fr");
  const french = said.map(again);
  assert.deepEqual(french.map((each) => each.replace(/\u2060/g, "")), ["avant", "avant", "quelqu’un a la commande"]);
  nextLanguage();
  assert.deepEqual(french.map(again), ["front", "ahead", "somebody has control"]);
  assert.equal(changes, 2);
  assert.equal(storage.getItem(KEPT), "en");
});

test("what servers say is known by what it looks like", async () => {
  const { translated } = await page({ languages: ["de"] });
  assert.equal(translated("the video server says 404"), "der Videoserver meldet 404");
  assert.equal(
    translated("slalom, day: 2 passed in a row, then 3 more passed; 12 of 14 repetitions are left"),
    "Slalom, Tag: 2 in Folge bestehen, danach 3 weitere bestehen; 12 von 14 Wiederholungen sind übrig",
  );
  assert.deepEqual(["40.76 s", "-0.5", "10.0.0.1", "3 s"].map(translated), ["40,76 s", "-0,5", "10.0.0.1", "3 s"]);
  assert.equal(translated("nobody has said this"), "nobody has said this");
});

test("figures are written as the language does", async () => {
  for (const [code, written] of Object.entries({ en: ["1.50", "0.0", "1234", "-2"], de: ["1,50", "0,0", "1234", "-2"], fr: ["1,50", "0,0", "1234", "-2"] })) {
    const { decimal } = await page({ languages: [code] });
    assert.deepEqual([decimal(1.5, 2), decimal(-0.04, 1), decimal(1234, 0), decimal(-2, 2, 0)], written);
  }
});

test("keys are called by what is printed on them", () => {
  const nothing = new Map();
  const caps = (/** @type {string} */ layout, /** @type {string[]} */ codes) => codes.map(capsOf(nothing, layout));
  assert.deepEqual(caps("de", ["KeyZ", "KeyY", "Minus", "Slash", "Delete", "Digit1"]), ["Y", "Z", "ß", "-", "Entf", undefined]);
  assert.deepEqual(caps("fr", ["KeyQ", "KeyM", "Delete"]), ["A", ",", "Suppr"]);
  assert.deepEqual(caps("us", ["KeyQ", "Delete"]), [undefined, undefined]);
  assert.deepEqual(caps("no such", ["KeyQ"]), [undefined]);
});

test("what the browser tells of the keyboard counts more than what was chosen", () => {
  const told = new Map([["KeyZ", "y"], ["KeyY", "z"], ["Digit1", "1"], ["Slash", "/"]]);
  assert.deepEqual(["KeyZ", "Digit1", "Slash", "Delete"].map(capsOf(told, "fr")), ["Y", undefined, undefined, undefined]);
  const german = new Map(Object.entries({
    KeyY: "z", KeyZ: "y", Slash: "-", IntlBackslash: "<", Backquote: "^", Minus: "ß", Equal: "´", BracketLeft: "ü", BracketRight: "+", Semicolon: "ö",
    Quote: "ä", Backslash: "#",
  }));
  assert.deepEqual(["Semicolon", "Delete"].map(capsOf(german, "us")), ["Ö", "Entf"]);
});

test("a keyboard is first thought to be that of the browser's language", () => {
  assert.deepEqual([["de-CH"], ["fr-FR"], ["en-GB"], ["de"], ["pt"], []].map(usualLayout), ["ch", "fr", "uk", "de", "us", "us"]);
});
