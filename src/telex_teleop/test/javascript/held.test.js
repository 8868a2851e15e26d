import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";

import { clock, paced } from "./browser.js";
import { Held } from "../../console/js/held.js";
import { keepPace } from "../../console/js/deadman.js";

let changes = 0;
/** @type {Held} */
let held;

beforeEach(() => {
  changes = 0;
  held = new Held(() => {
    changes += 1;
  });
});

test("an action is held until the last source lets go of it", () => {
  held.press("key:KeyW", "forward");
  held.press("pointer:1", "forward");
  held.release("key:KeyW");
  assert.deepEqual([...held.actions], ["forward"]);
  held.release("pointer:1");
  assert.ok(held.empty);
});

test("the farthest of those who hold an action counts", () => {
  held.press("pad:0", "forward", 0.3);
  held.press("key:KeyW", "forward");
  assert.equal(held.amounts.get("forward"), 1);
  held.release("key:KeyW");
  assert.equal(held.amounts.get("forward"), 0.3);
});

test("a stick that moves on is no new press", () => {
  held.press("pad:0", "forward", 0.3);
  held.press("pad:0", "forward", 0.6);
  assert.equal(changes, 1);
  assert.equal(held.amounts.get("forward"), 0.6);
  held.press("pad:0", "backward", 0.6);
  assert.equal(changes, 2);
});

test("letting go of what nobody holds is no change", () => {
  held.release("key:KeyW");
  assert.equal(changes, 0);
});

test("everything is let go at once", () => {
  held.press("key:KeyW", "forward");
  held.press("key:KeyA", "left");
  held.releaseAll();
  assert.ok(held.empty);
  assert.equal(changes, 3);
});

test("after a standstill of the page nothing is held any more, not even what is pressed first", () => {
  /** @type {string[]} */
  const reasons = [];
  keepPace(20, () => {}, (reason) => reasons.push(reason));
  held.press("key:KeyW", "forward");
  clock.now += 350;
  held.press("key:KeyA", "left");
  assert.ok(held.empty);
  paced[0]();
  assert.match(reasons[0], /stood still for 0\.[34] s/);
  held.press("key:KeyA", "left");
  assert.deepEqual([...held.actions], ["left"]);
});
