// @ts-check
/** What exercises say in another language than that of their files. */

import assert from "node:assert/strict";
import { test } from "node:test";

import { FakeStorage } from "./browser.js";

// The language is decided when the modules come.
Object.defineProperty(globalThis, "document", { value: {}, configurable: true });
Object.defineProperty(globalThis, "location", { value: { search: "?lang=de" }, configurable: true });
Object.defineProperty(globalThis, "localStorage", { value: new FakeStorage({}), configurable: true });
Object.defineProperty(globalThis, "navigator", { value: {}, configurable: true });
const { addTexts, translated } = await import("../../console/js/language.js");
const { answerOf, choiceText, metricText, told, zonesOf } = await import("../../console/js/language/exercise.js");
const seen = (/** @type {string} */ words) => words.replaceAll("\u2060", "");

test("a condition is declined, and its figures are written, as the language does", () => {
  const touches = { english: "{who} touches {what}", values: { who: "the robot", what: "the beam|object" } };
  assert.equal(seen(told({ english: "{clause} for {seconds} s", values: { clause: touches, seconds: 0.5 } })), "der Roboter berührt den Balken, 0,5 s lang");
});

test("what no table has is said as its file has it", () => {
  const inside = { english: "{what} is in '{zone}'", values: { what: "the crane|object", zone: "dock|zone" } };
  assert.equal(seen(told(inside)), "the crane ist in „dock“");
  assert.equal(seen(metricText("largest 20 ms mean of the force, crane")), "größtes 20-ms-Mittel der Kraft, crane");
  assert.equal(seen(choiceText("seven")), "seven");
});

test("names in a picture of the goal are told beside those of the language", () => {
  const inside = (/** @type {string} */ zone) => ({ english: "{what} is in '{zone}'", values: { what: "the robot", zone: `${zone}|zone` } });
  assert.equal(zonesOf([{ english: "{clause} for {seconds} s", values: { clause: inside("target"), seconds: 1 } }, inside("start"), inside("target")]), " target = Ziel, start = Start");
  assert.equal(zonesOf([inside("dock")]), "");
});

test("a metric's own commas are none before an object", () => {
  assert.equal(seen(metricText("largest error of a map by the odometry, along the survey")), "größter Fehler einer Karte nach Odometrie entlang der Messung");
  assert.equal(seen(metricText("largest 20 ms mean of the force, beam, second")), "größtes 20-ms-Mittel der Kraft, Balken, zweiter Roboter");
});

test("directions are understood in the language in which they are asked for, and in English", () => {
  assert.equal(answerOf("Rechts, rechts oben;links , ?"), "right, up right, left, ?");
  assert.equal(answerOf("up right, up"), "up right, up");
  assert.equal(answerOf("7"), "7");
});

test("what nodes put together is said part by part, with figures as the language has them", () => {
  assert.equal(
    seen(translated("slowed to 40 %: wrist_joint is 5.2 deg from its limit; the tool keeps its place in the world")),
    "auf 40 % verlangsamt: wrist_joint ist 5,2° vor seiner Grenze; das Werkzeug hält seinen Ort in der Welt",
  );
  assert.equal(seen(translated("the scene cannot be loaded: sim/load_scene has not answered for 20 s")), "die Szene kann nicht geladen werden: sim/load_scene hat seit 20 s nicht geantwortet");
  assert.equal(seen(translated("lift, repetition 2")), "anheben, Wiederholung 2");
});

test("texts that an exercise has of its own are known once they have come", () => {
  const title = "Fetch the crane";
  assert.equal(translated(title), title);
  addTexts({ de: { [title]: "Den Kran holen", "the crane|object": "den Kran" }, fr: {}, tlh: { [title]: "qul" } });
  assert.equal(seen(translated(title)), "Den Kran holen");
  assert.equal(seen(told({ english: "the gripper holds {what}", values: { what: "the crane|object" } })), "der Greifer hält den Kran");
  // A station's file changes nothing that pages say themselves.
  addTexts({ de: { "the robot": "das Ding" } });
  assert.equal(seen(translated("the robot")), "der Roboter");
});
