// @ts-check
/** What is kept where the browser keeps nothing. */

import assert from "node:assert/strict";
import { test } from "node:test";

import { FakeStorage } from "./browser.js";
import { made } from "./actions.js";
import { KeyMap } from "../../console/js/keymap.js";
import { storage } from "../../console/js/storage.js";
import { rememberOperator, rememberedOperator } from "../../console/js/training/client.js";

const browsers = /** @type {[string, PropertyDescriptor][]} */ ([
  ["does not let it be looked at", { get() { throw new Error("SecurityError"); } }],
  ["has no room", { value: { getItem: () => null, setItem() { throw new Error("QuotaExceededError"); } } }],
]);

for (const [name, localStorage] of browsers) {
  test(`a browser that ${name} has keys and operator until the page is closed`, () => {
    Object.defineProperty(globalThis, "localStorage", { ...localStorage, configurable: true });
    assert.equal(storage.getItem(name), null);
    storage.setItem(name, "kept");
    assert.equal(storage.getItem(name), "kept");
    const keys = new KeyMap(storage, made());
    keys.set("estop", "F13");
    assert.equal(new KeyMap(storage, made()).codeOf("estop"), "F13");
    rememberOperator("Ann");
    assert.equal(rememberedOperator(), "Ann");
  });
}

test("what there is room for again is the browser's", () => {
  const browser = new FakeStorage({ name: "old" });
  Object.defineProperty(globalThis, "localStorage", { value: { getItem: () => "old", setItem() { throw new Error("QuotaExceededError"); } }, configurable: true });
  storage.setItem("name", "new");
  Object.defineProperty(globalThis, "localStorage", { value: browser, configurable: true });
  assert.equal(storage.getItem("name"), "new");
  storage.setItem("name", "newest");
  assert.equal(browser.values.name, "newest");
  browser.setItem("name", "by another page");
  assert.equal(storage.getItem("name"), "by another page");
});
