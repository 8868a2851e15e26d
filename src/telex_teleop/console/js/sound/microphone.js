// @ts-check
/** What a microphone makes of what it hears: it hisses, and clips what is too loud for it. */

/** Sound pressure (dB) at the hull of motors that are as loud as any. */
const LOUDEST = 90;

/** @typedef {{hiss: number, limit: number}} MicrophoneSound  Of what is as loud as any, 0 to 1: its own noise; what it clips at. */

/**
 * @param {any} declared  `equipment.microphone` of /robot.json, with its own noise and the most that it takes (dB); undefined: there is none.
 * @returns {MicrophoneSound}
 */
export function microphoneSound(declared) {
  return { hiss: loudness(declared?.noise, 0), limit: loudness(declared?.max, 1) };
}

/**
 * @param {unknown} pressure  dB
 * @param {number} otherwise  Where it is not told.
 */
function loudness(pressure, otherwise) {
  return typeof pressure === "number" && Number.isFinite(pressure) ? Math.min(1, 10 ** ((pressure - LOUDEST) / 20)) : otherwise;
}
