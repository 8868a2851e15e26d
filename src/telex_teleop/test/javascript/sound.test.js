// @ts-check
/** What motors, tracks, touch and alarms sound like, and which alarm sounds now. */

import "./browser.js";
import assert from "node:assert/strict";
import { test } from "node:test";
import { Alarms } from "../../console/js/sound/alarms.js";
import { areAids, rights } from "../../console/js/sound/allowed.js";
import { microphoneSound } from "../../console/js/sound/microphone.js";
import { Motors, groundSound, motorSound, share } from "../../console/js/sound/motors.js";
import { ALARMS, lengthOf } from "../../console/js/sound/patterns.js";
import { rumble } from "../../console/js/sound/rumble.js";
import { Touch } from "../../console/js/sound/touch.js";
import { localVoice } from "../../console/js/sound/voice.js";

const NO_NUMBERS = [NaN, Infinity, -Infinity, null, undefined];
const GROUPS = /** @type {const} */ (["tracks", "flippers", "arm"]);

test("a motor is higher the faster it runs, rougher and louder with its load, and silent at rest", () => {
  for (const group of GROUPS) {
    const rest = motorSound(group, { speed: 0, load: 1 }), slow = motorSound(group, { speed: 0.2, load: 0.1 });
    const fast = motorSound(group, { speed: 0.9, load: 0.1 }), heavy = motorSound(group, { speed: 0.2, load: 0.9 });
    assert.equal(rest.gain, 0);
    assert.ok(fast.pitch > slow.pitch && fast.gain > slow.gain);
    assert.ok(heavy.tone > slow.tone && heavy.gain > slow.gain);
    assert.equal(heavy.pitch, slow.pitch);
  }
  const pitches = GROUPS.map((group) => motorSound(group, { speed: 0.5, load: 0.5 }).pitch);
  assert.equal(new Set(pitches).size, GROUPS.length);
});

test("no number makes a sound that is none", () => {
  for (const value of /** @type {any[]} */ (NO_NUMBERS)) {
    assert.equal(share(value, 1), 0);
    assert.equal(share(1, value), 0);
    assert.equal(share(1, 0), 0);
    for (const group of GROUPS) assert.equal(motorSound(group, { speed: value, load: value }).gain, 0);
    assert.equal(groundSound("gravel", value).gain, 0);
    assert.ok(Object.values(motorSound("arm", { speed: 0.5, load: value })).every(Number.isFinite));
    const motors = new Motors();
    motors.hear({ name: ["left_wheel"], velocity: [value], effort: [value] });
    assert.deepEqual(motors.runs.tracks, { speed: 0, load: 0 });
    assert.deepEqual(new Touch().feel({ slipping: true, slip_speed: value, pads: [{ link: "pad", normal_force: value }] }), { knock: 0, slip: 0.2 });
  }
});

test("a microphone hisses as it declares, and clips what is too loud for it", () => {
  const shipped = microphoneSound({ noise: 34, max: 110 }), poor = microphoneSound({ noise: 70, max: 84 });
  assert.ok(shipped.hiss > 0 && shipped.hiss < 0.01 && shipped.limit === 1);
  assert.ok(Math.abs(poor.hiss - 0.1) < 1e-9 && poor.limit > 0.4 && poor.limit < 0.6);
  for (const value of [...NO_NUMBERS, "34"]) assert.deepEqual(microphoneSound({ noise: value, max: value }), { hiss: 0, limit: 1 });
  assert.deepEqual(microphoneSound(undefined), { hiss: 0, limit: 1 });
});

test("each surface has its own noise; in the air there is none", () => {
  const grounds = ["concrete", "gravel", "wood", "painted_metal"].map((surface) => groundSound(surface, 0.5));
  assert.equal(new Set(grounds.map(({ pitch, width }) => `${pitch} ${width}`)).size, grounds.length);
  assert.ok(grounds.every(({ gain }) => gain > 0));
  assert.equal(groundSound("", 0.5).gain, 0);
  assert.equal(groundSound("concrete", 0).gain, 0);
  assert.ok(groundSound("concrete", 0.8).beat > groundSound("concrete", 0.2).beat);
  assert.ok(groundSound("lava", 0.5).gain > 0);
});

test("motors are told apart by the nodes that move them, whatever the robot calls its joints", () => {
  const motors = new Motors();
  motors.setNode("arm_teleop", ["elbow"]);
  motors.setNode("flipper_teleop", ["leg"]);
  motors.setLimits(new Map([["wheel", { velocity: 10, effort: 4 }], ["elbow", { velocity: 2, effort: 100 }]]));
  motors.hear({ name: ["wheel", "leg", "elbow"], velocity: [-5, 0, 0.5], effort: [2, 9, -50] });
  assert.deepEqual(motors.runs, { tracks: { speed: 0.5, load: 0.5 }, flippers: { speed: 0, load: 0 }, arm: { speed: 0.25, load: 0.5 } });
  motors.forget();
  assert.equal(motors.runs.tracks.speed, 0);
  // Of a joint without limits the most that it was seen to do counts.
  motors.hear({ name: ["leg"], velocity: [4], effort: [8] });
  motors.hear({ name: ["leg"], velocity: [2] });
  assert.deepEqual(motors.runs.flippers, { speed: 0.5, load: 0 });
});

test("alarms differ by pitch or rhythm, and all are told in words", () => {
  const heard = ALARMS.map(({ tones }) => JSON.stringify(tones));
  assert.equal(new Set(heard).size, ALARMS.length);
  const rhythms = ALARMS.map(({ tones }) => `${tones.length} ${tones[1].at}`);
  assert.equal(new Set(rhythms).size, ALARMS.length);
  for (const alarm of ALARMS) {
    assert.ok(alarm.words().length > 0);
    assert.ok(lengthOf(alarm) < alarm.every);
  }
  for (const name of ["tipping", "e-stop", "link lost", "link poor", "picture old", "guard", "battery", "dose"]) {
    assert.ok(ALARMS.some((alarm) => alarm.name === name), name);
  }
});

/** @param {Alarms} alarms @param {number} from @param {number} to */
function heardFrom(alarms, from, to) {
  const heard = [];
  for (let now = from; now < to; now += 0.2) {
    const due = alarms.next(now);
    if (due !== null) heard.push(due.alarm.name);
  }
  return heard;
}

test("of several alarms the gravest sounds first, and cuts off a lesser one", () => {
  const alarms = new Alarms(ALARMS);
  alarms.see(["battery", "e-stop"], 10);
  assert.equal(alarms.next(10)?.alarm.name, "e-stop");
  assert.equal(alarms.next(10.2), null);
  alarms.see(["battery", "e-stop", "tipping"], 10.4);
  assert.deepEqual(alarms.next(10.4), { alarm: ALARMS[0], isFirst: true });
  assert.ok(alarms.sounds("tipping", 10.6) && !alarms.sounds("e-stop", 10.6));
  alarms.see(["battery", "e-stop"], 10.6);
  assert.ok(heardFrom(alarms, 10.6, 20).includes("battery"));
});

test("no alarm sounds for ever, and what flickers is no new one", () => {
  const alarms = new Alarms(ALARMS);
  const guard = /** @type {import("../../console/js/sound/patterns.js").Alarm} */ (ALARMS.find(({ name }) => name === "guard"));
  const heard = [];
  for (let now = 0; now < 60; now += 0.2) {
    alarms.see(Math.round(now) % 2 ? ["guard"] : [], now);
    if (alarms.next(now) !== null) heard.push(now);
  }
  assert.equal(heard.length, guard.times);
  assert.deepEqual(alarms.pending, []);
  alarms.see([], 80);
  alarms.see(["guard"], 90);
  assert.deepEqual(alarms.pending, ["guard"]);
  assert.equal(alarms.next(90)?.isFirst, true);
});

test("an alarm that was acknowledged is silent until it begins anew", () => {
  const alarms = new Alarms(ALARMS);
  alarms.see(["link lost"], 0);
  alarms.next(0);
  alarms.acknowledge();
  assert.ok(!alarms.sounds("link lost", 0.1));
  for (let now = 1; now < 30; now += 1) alarms.see(["link lost"], now);
  assert.deepEqual(heardFrom(alarms, 1, 30), []);
  // Another one is heard all the same.
  alarms.see(["link lost", "dose"], 30);
  assert.equal(alarms.next(30)?.alarm.name, "dose");
  alarms.see([], 31);
  alarms.see(["link lost"], 40);
  assert.equal(alarms.next(40)?.alarm.name, "link lost");
});

test("only a voice of this machine speaks, and only in the page's language", () => {
  const remote = { lang: "de-DE", localService: false }, german = { lang: "de-DE", localService: true };
  const swiss = { lang: "de_CH", localService: true }, english = { lang: "en-US", localService: true };
  assert.equal(localVoice([remote, english, german], "de"), german);
  assert.equal(localVoice([german, swiss], "de-CH"), swiss);
  assert.equal(localVoice([remote, english], "de"), null);
  assert.equal(localVoice([], "en"), null);
  assert.equal(localVoice([/** @type {any} */ ({ lang: "en-US" })], "en"), null);
});

test("a pad is felt once as it touches, and again only after it has let go", () => {
  const touch = new Touch();
  const feel = (/** @type {number} */ force) => touch.feel({ pads: [{ link: "left", normal_force: force }] }).knock;
  assert.equal(feel(0), 0);
  const soft = feel(1);
  assert.ok(soft > 0);
  assert.equal(feel(30), 0);
  assert.equal(feel(0.3), 0);
  assert.equal(feel(1), 0);
  assert.equal(feel(0), 0);
  assert.ok(feel(30) > soft);
  assert.ok(touch.feel({ slipping: true, slip_speed: 0.08 }).slip > touch.feel({ slipping: true, slip_speed: 0.01 }).slip);
  assert.equal(touch.feel({ slipping: false, slip_speed: 0.01 }).slip, 0);
});

test("pads rumble that can, within what they take", () => {
  /** @type {any[]} */
  const effects = [];
  const pad = /** @type {any} */ ({
    vibrationActuator: {
      playEffect(/** @type {string} */ kind, /** @type {any} */ effect) {
        effects.push([kind, effect]);
        return Promise.reject(new Error("it was pulled out"));
      },
    },
  });
  rumble([null, /** @type {any} */ ({}), pad], 1.5, 0.25, 100);
  assert.deepEqual(effects, [["dual-rumble", { duration: 100, strongMagnitude: 1, weakMagnitude: 0.25 }]]);
  rumble([pad], NaN, 0, 100);
  assert.equal(effects.length, 1);
});

test("what the robot has no microphone for is a training aid in practice, and not there in an exam", () => {
  assert.deepEqual(rights({ microphone: {} }, true), { motors: "equipment", tracks: "equipment", touch: "equipment" });
  assert.deepEqual(rights({}, false), { motors: "aid", tracks: "none", touch: "aid" });
  assert.deepEqual(rights({ pads: {} }, true), { motors: "none", tracks: "none", touch: "equipment" });
  assert.deepEqual([{}, { pads: {} }, { microphone: {} }].map((each) => areAids(rights(each, false))), [true, true, false]);
  assert.ok(!areAids(rights({}, true)));
});
