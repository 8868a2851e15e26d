import assert from "node:assert/strict";
import { test } from "node:test";

import { clock } from "./browser.js";
import { Tally } from "../../console/js/tally.js";

const steps = (/** @type {number} */ painted, /** @type {number | null} */ captured) => ({ captured, received: painted, decoded: painted, painted });

test("pictures count in the second in which they are painted", () => {
  clock.now = 0;
  const tally = new Tally();
  for (const at of [100, 900, 2500]) tally.add("front", steps(at, at - 50));
  clock.now = 3000;
  const { length, cameras } = tally.take();
  assert.equal(length, 3);
  assert.deepEqual(cameras.front.seconds, [2, 0, 1]);
});

test("a picture grows old until the next one is painted, and goes on to after a look", () => {
  clock.now = 0;
  const tally = new Tally();
  tally.add("front", steps(100, 60));
  tally.add("front", steps(700, 680));
  clock.now = 800;
  assert.equal(tally.take().cameras.front.oldest, 640);
  clock.now = 2000;
  const { cameras } = tally.take();
  assert.equal(cameras.front.oldest, 1320);
  assert.deepEqual(cameras.front.last, []);
});

test("a picture that does not tell when it was taken has no age", () => {
  clock.now = 0;
  const tally = new Tally();
  tally.add("front", steps(100, null));
  clock.now = 5000;
  assert.equal(tally.take().cameras.front.oldest, 0);
});
