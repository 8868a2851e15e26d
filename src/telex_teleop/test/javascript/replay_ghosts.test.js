// @ts-check
/** What the replay's page says of the runs that can be drawn beside a trial. */

import "./browser.js";
import assert from "node:assert/strict";
import { test } from "node:test";
import { aheadText, runText } from "../../../telex_training/pages/replay/ghosts.js";

const RUN = { ghost: "2026-11-24_153955_ann_slalom", operator: "ann", seconds: 34.26, same_places: true };

test("a run says whose it is, when and how fast it was", () => {
  assert.equal(runText(RUN), "ann, 2026-11-24 15:39: 34.3 s");
  assert.equal(runText({ ...RUN, operator: "", ghost: "t1" }), "no name, t1: 34.3 s");
  assert.equal(runText({ ...RUN, ghost: "expert", same_places: false }), "the expert: 34.3 s, things stood elsewhere");
});

test("by how much the ghost is before the trial", () => {
  assert.equal(aheadText(null), "");
  assert.equal(aheadText("0.020"), "ghost level");
  assert.equal(aheadText("1.240"), "ghost 1.2 s ahead");
  assert.equal(aheadText("-3.000"), "ghost 3.0 s behind");
});
