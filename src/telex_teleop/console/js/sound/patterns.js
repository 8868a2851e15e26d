// @ts-check
/** What alarms sound like: each differs from all others by pitch and rhythm, and is told in words where the browser has a voice of its own. */

import { text } from "../language.js";

/** @typedef {{at: number, pitch: number, length: number, to?: number}} Tone  s from the beginning, Hz, s; `to`: the pitch at its end (Hz). */

/**
 * @typedef {object} Alarm
 * @property {string} name
 * @property {() => string} words  Said once it begins.
 * @property {Tone[]} tones
 * @property {number} every  From one time to the next (s), while what it tells of goes on.
 * @property {number} times  How often it sounds at most.
 */

/**
 * The same tone again and again.
 * @param {number} count
 * @param {number} period  s
 * @param {number} length  s
 * @param {(number | [number, number])[]} pitches  Hz, one after the other, over and over; of two it glides from one to the other.
 * @returns {Tone[]}
 */
function beat(count, period, length, pitches) {
  return Array.from({ length: count }, (_, index) => {
    const pitch = pitches[index % pitches.length];
    const glide = Array.isArray(pitch) ? { pitch: pitch[0], to: pitch[1] } : { pitch };
    return { at: index * period, length, ...glide };
  });
}

/** The gravest first: of several at once the first one sounds. @type {Alarm[]} */
export const ALARMS = [
  // A siren: high and low by turns, fast.
  { name: "tipping", words: () => text("Tipping over"), tones: beat(8, 0.11, 0.1, [1180, 790]), every: 2, times: 4 },
  // Three long low tones, as heavy machines have.
  { name: "e-stop", words: () => text("Emergency stop"), tones: beat(3, 0.36, 0.28, [330]), every: 8, times: 2 },
  // A long fall, twice.
  { name: "link lost", words: () => text("Connection lost"), tones: beat(2, 0.5, 0.42, [[880, 220]]), every: 4, times: 3 },
  // Two even tones in the middle, far apart.
  { name: "picture old", words: () => text("Picture is old"), tones: beat(2, 0.45, 0.18, [587]), every: 5, times: 3 },
  // A rattle, as of a counter.
  { name: "dose", words: () => text("Radiation alarm"), tones: beat(14, 0.055, 0.018, [2400]), every: 6, times: 3 },
  // As of a car that is being parked.
  { name: "guard", words: () => text("Close to an obstacle"), tones: beat(4, 0.14, 0.06, [1560]), every: 4, times: 2 },
  // A single warble down and up.
  { name: "link poor", words: () => text("Connection poor"), tones: beat(2, 0.26, 0.24, [[740, 554], [554, 740]]), every: 15, times: 2 },
  // Two steps down, slow and soft.
  { name: "battery", words: () => text("Battery low"), tones: beat(2, 0.4, 0.32, [494, 370]), every: 60, times: 2 },
];

/** How long an alarm's tones take (s). @param {Alarm} alarm */
export const lengthOf = ({ tones }) => Math.max(...tones.map(({ at, length }) => at + length));
