// @ts-check
/** Rays through pixels, and plans of scenes, without a browser. */

import assert from "node:assert/strict";
import test from "node:test";

import { pointIn, rayThrough } from "../../console/js/instructor/arranging/ray.js";
import { ScenePlan } from "../../console/js/instructor/arranging/scene_plan.js";

const INFO = { width: 640, height: 480, D: [], K: [500, 0, 320, 0, 400, 240, 0, 0, 1] };
/** Looks along the world's x: its z ahead, its x to the right (-y), its y down (-z). */
const AHEAD = { position: { x: 1, y: 2, z: 3 }, orientation: { x: -0.5, y: 0.5, z: -0.5, w: 0.5 } };

const near = (/** @type {number} */ a, /** @type {number} */ b) => assert.ok(Math.abs(a - b) < 1e-6, `${a} is not ${b}`);

test("the middle of the picture is straight ahead, its right is right", () => {
  const { origin, direction } = rayThrough(INFO, AHEAD, 0.5, 0.5);
  assert.deepEqual(origin, AHEAD.position);
  [near(direction.x, 1), near(direction.y, 0), near(direction.z, 0)];
  const corner = rayThrough(INFO, AHEAD, 1, 1).direction;
  [near(corner.x, 1), near(corner.y, -320 / 500), near(corner.z, -240 / 400)];
});

test("a lens is undone", () => {
  const D = [-0.28, 0.09, 0.001, -0.0005, -0.01];
  const [x, y] = [0.4, -0.3], r = x * x + y * y;
  const radial = 1 + D[0] * r + D[1] * r * r + D[4] * r * r * r;
  const u = x * radial + 2 * D[2] * x * y + D[3] * (r + 2 * x * x);
  const v = y * radial + D[2] * (r + 2 * y * y) + 2 * D[3] * x * y;
  const { direction } = rayThrough({ ...INFO, D }, AHEAD, (u * 500 + 320) / 640, (v * 400 + 240) / 480);
  [near(direction.y, -x), near(direction.z, -y)];
});

test("a picture is shown whole, in the middle and from the top on", () => {
  const box = /** @type {DOMRect} */ ({ left: 10, top: 20, width: 500, height: 200 });
  assert.deepEqual(pointIn(box, 2, { clientX: 60, clientY: 20 }), [0, 0]);
  assert.deepEqual(pointIn(box, 2, { clientX: 260, clientY: 120 }), [0.5, 0.5]);
  assert.equal(pointIn(box, 2, { clientX: 59, clientY: 120 }), null, "beside it");
});

test("a plan knows where things are as soon as their poses come", () => {
  const square = { corners: [4], outlines: [1, 0, 0, 1, -1, 0, 0, -1] };
  const plan = new ScenePlan({
    revision: 7, floor: 40, frames: ["world", "telex/base_link", "box/body"], robots: ["telex"], bases: ["telex/base_link"],
    objects: [
      { name: "wall", movable: false, frame: "world", bottom: 0, top: 2, ...square },
      { name: "box", movable: true, frame: "box/body", bottom: 0, top: 0.2, ...square },
    ],
  });
  const [wall, box] = plan.things;
  assert.deepEqual(plan.outlines(box), [], "not known yet");
  const still = [0, 0, 0, 0, 0, 0, 1], half = Math.SQRT1_2;
  assert.equal(plan.hear({ revision: 6, poses: still }), false, "poses of another scene");
  assert.equal(plan.hear({ revision: 7, poses: [...still, 8, -3, 0.1, 0, 0, half, half, 5, 6, 0, 0, 0, half, half] }), true);
  assert.deepEqual(plan.outlines(wall)[0][0], [1, 0]);
  const [[x, y]] = plan.outlines(box)[0];
  [near(x, 5), near(y, 7)];
  near(/** @type {any} */ (plan.place(plan.robots[0].frame)).heading, Math.PI / 2);
  assert.deepEqual(plan.extent, { left: -2, right: 8, low: -3, high: 2 });
});
