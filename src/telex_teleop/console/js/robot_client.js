// @ts-check
/** The robot as the pages' panels speak to it: topics and services by their names in its namespace, and messages to whoever is at the page. */

import { translated } from "./language.js";

export class RobotClient {
  /**
   * @param {import("./bridge.js").Bridge} bridge
   * @param {(name: string) => string} topic  Gives a name inside the robot's namespace its global form.
   * @param {(sentence: string) => void} log
   * @param {(sentence: string) => void} warn
   */
  constructor(bridge, topic, log, warn) {
    this.bridge = bridge;
    this.topic = topic;
    this.log = log;
    this.warn = warn;
  }

  /**
   * @param {string} name
   * @param {string} type
   * @param {(message: any) => void} heard
   * @param {number} [throttle]  Least time (ms) between two messages.
   */
  subscribe(name, type, heard, throttle = 0) {
    this.bridge.subscribe({ topic: this.topic(name), type, throttle, heard });
  }

  /**
   * Call a service.
   * @param {string} name
   * @param {object} args
   * @param {number} [within]  Time (ms) after which the call is given up.
   * @returns {Promise<any>} Its answer; rejected as `Bridge.call` says.
   */
  call(name, args, within) {
    return this.bridge.call(this.topic(name), args, within);
  }

  /**
   * Call a service, and warn where it refuses or does not answer.
   * @param {string} name
   * @param {object} args
   * @param {(why: string) => string} [unanswered]  What to say, given the reason, where no answer came.
   * @param {number} [within]  Time (ms) after which the call is given up.
   * @returns {Promise<any>} Its answer; null where there is none, or a refusal.
   */
  async request(name, args, unanswered = (why) => why, within) {
    try {
      const answer = await this.call(name, args, within);
      if (answer.success !== false) return answer;
      this.warn(translated(answer.message));
    } catch (error) {
      this.warn(unanswered(translated(/** @type {Error} */ (error).message)));
    }
    return null;
  }
}
