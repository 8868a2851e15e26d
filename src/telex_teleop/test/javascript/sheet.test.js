// @ts-check
/** The page of a sheet: what stands beside the sheet when its language changes. */

import "./browser.js";
import assert from "node:assert/strict";
import { test } from "node:test";
import { addTexts, nextLanguage } from "../../console/js/language.js";
import "../../../telex_training/pages/replay/language.js"; // before there is a page: it finds the console's files beside this package

class FakeElement {
  constructor() {
    Object.assign(this, { value: "", disabled: false, text: "" });
    /** @type {any} */
    this.parent = null;
    /** @type {any[]} */
    this.children = [];
    /** @type {Record<string, string>} */
    this.attributes = {};
    /** @type {Record<string, (event: any) => any>} */
    this._listeners = {};
  }

  set textContent(text) {
    Object.assign(this, { text });
  }

  /** @param {string} name @param {string} value */
  setAttribute(name, value) {
    this.attributes[name] = value;
    if (name === "value") Object.assign(this, { value });
  }

  /** @param {string} kind @param {(event: any) => void} hear */
  addEventListener(kind, hear) {
    this._listeners[kind] = hear;
  }

  /** @param {string} kind */
  fire(kind) {
    return this._listeners[kind]({ preventDefault() {} });
  }

  /** @param {any[]} children */
  append(...children) {
    for (const child of children) this._insert(this.children.length, child);
  }

  /** @param {any[]} children */
  replaceChildren(...children) {
    this.children = [];
    this.append(...children);
  }

  /** @param {any} other */
  after(other) {
    this.parent._insert(this.parent.children.indexOf(this) + 1, other);
  }

  /** @param {any} other */
  before(other) {
    this.parent._insert(this.parent.children.indexOf(this), other);
  }

  /** @param {any} other */
  replaceWith(other) {
    this.before(other);
    this.parent.children.splice(this.parent.children.indexOf(this), 1);
  }

  /** @param {number} place @param {any} child */
  _insert(place, child) {
    this.children.splice(place, 0, child);
    child.parent = this;
  }

  /** All elements in it. @returns {any[]} */
  get all() {
    return this.children.flatMap((child) => (child instanceof FakeElement ? [child, ...child.all] : []));
  }

  /** @param {string} selector  A class. */
  querySelector(selector) {
    return this.all.find(({ attributes }) => attributes.class === selector.slice(1)) ?? null;
  }
}

const SHEET = {
  exercise: { title: "Slalom", setting: "standard", seed: 1 }, verdict: "passed", valid: true, operator: "Ann", mode: "exam", ended: "done",
  summary: { completed: 1, faults: 0, proficiency: null, reliability: null, confidence: null }, expert: {}, marks: [], metrics: [],
  events: [], repetitions: [], trial: "T", software: "s", log: { sha256: "", samples: 1, gaps: 0 }, real_time_factor: { mean: 1 },
};
const RATED = { ratings: [10, 10, 10, 10, 10, 10], raw: 10 };

const main = new FakeElement();
/** What was asked for, and how it is answered. @type {Record<string, (reply: any) => void>} */
const open = {};
/** @type {string[]} */
const fetched = [];
Object.assign(globalThis, {
  location: { search: "?trial=T&name=Ann", href: "http://x/?trial=T" }, history: { replaceState() {} }, NodeFilter: {},
  document: {
    createElement: () => new FakeElement(), getElementById: (/** @type {string} */ id) => (id === "sheet" ? main : null), documentElement: {},
    createTreeWalker: () => ({ nextNode: () => null }), querySelectorAll: () => [],
  },
  fetch: (/** @type {string} */ address) => {
    const [, name] = /** @type {RegExpExecArray} */ (/^api\/(\w+)/.exec(address));
    fetched.push(name);
    return new Promise((resolve) => { open[name] = (reply) => resolve({ ok: true, status: 200, json: async () => reply }); });
  },
});

const settled = () => new Promise((resolve) => setImmediate(resolve));

/** Elements with an id, and what they say. */
const marked = () => main.all.filter(({ attributes }) => attributes.id).map(({ attributes, text }) => [attributes.id, text]);

test("signature and workload come once, and stay through other languages as they were filled in", async () => {
  await import(`${"../../../telex_training/pages/sheet.js"}`);
  open.sheet(SHEET);
  await settled();
  nextLanguage(); // while both are under way
  open.signature("valid, signed by Lab 2");
  open.workload(null);
  await settled();
  assert.deepEqual(marked(), [["signature", "Signatur: gültig, signiert von Lab 2"], ["workload", ""]]);

  const sliders = () => main.all.filter(({ attributes }) => attributes.type === "range");
  for (const slider of sliders()) {
    slider.value = "10";
    slider.fire("input");
  }
  const send = main.all.find(({ attributes }) => attributes.type === "submit");
  assert.equal(send.disabled, false);
  addTexts({ de: { "of its own": "eigener" } });
  nextLanguage();
  assert.deepEqual(marked().map(([id]) => id), ["signature", "workload"]);
  assert.deepEqual(sliders().map(({ value }) => value), Array(6).fill("10"));
  assert.ok(main.all.includes(send));

  const sent = main.all.find(({ _listeners }) => _listeners.submit).fire("submit");
  open.workload(RATED);
  await sent;
  assert.match(marked()[1][1], /^Charge/);
  nextLanguage();
  assert.deepEqual(marked(), [
    ["signature", "Signature: valid, signed by Lab 2"],
    ["workload", "Workload 10 of 100 (NASA-TLX, unweighted): Mental demand 10, Physical demand 10, Temporal demand 10, Performance 10, Effort 10, Frustration 10"],
  ]);
  assert.deepEqual(fetched.filter((name) => name !== "texts"), ["sheet", "signature", "workload", "workload"]);
});
