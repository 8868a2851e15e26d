// @ts-check
/** Calls of services whose refusals the page tells. */

import { translated } from "./language.js";

/**
 * Call a service; say why where it refuses or does not answer.
 * @param {import("./bridge.js").Bridge} bridge
 * @param {string} service
 * @param {object} args
 * @param {(sentence: string) => void} warn
 * @param {(why: string) => string} [unanswered]  What to say, given the reason, where no answer came.
 * @param {number} [within]  Time (ms) after which the call is given up.
 * @returns {Promise<any>} The answer; null where there is none, or a refusal.
 */
export async function request(bridge, service, args, warn, unanswered = (why) => why, within) {
  try {
    const answer = await bridge.call(service, args, within);
    if (answer.success !== false) return answer;
    warn(translated(answer.message));
  } catch (error) {
    warn(unanswered(translated(/** @type {Error} */ (error).message)));
  }
  return null;
}
