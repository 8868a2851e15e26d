// @ts-check
/** Client of the training node. */

import { onLanguage } from "../language.js";
import { storage } from "../storage.js";

/** Phases of a trial that has begun and has not ended. */
export const BEGUN = ["preparing", "waiting", "running", "between"];

export const TYPES = {
  state: "telex_msgs/TrainingState",
  telemetry: "std_msgs/String",
};
/** Address of what exercises say in other languages by their own files. */
export const TEXTS = "/training/api/texts";
const SLOW = 30_000; // ms within which a scene is loaded
const OPERATOR = "telex.operator"; // where the browser keeps whose name was typed last

/**
 * @typedef {object} State  telex_msgs/TrainingState
 * @property {string} phase
 * @property {string} trial
 * @property {string} exercise
 * @property {string} title
 * @property {string} setting
 * @property {string} mode
 * @property {string} operator
 * @property {boolean} valid
 * @property {string[]} invalid_because
 * @property {number} repetition
 * @property {number} repetitions
 * @property {string} from_bookmark
 * @property {string[]} bookmarks
 * @property {string[]} results
 * @property {number} elapsed
 * @property {number} penalty
 * @property {number} trial_elapsed
 * @property {number} trial_limit
 * @property {string[]} steps
 * @property {boolean[]} steps_done
 * @property {string[]} faults
 * @property {{name: string, ask: string, choices: string[], answered: boolean}[]} questions
 * @property {string[]} malfunctions announced ones
 * @property {string} hint
 * @property {string} message
 * @property {boolean} help  The operator asks for the instructor.
 * @property {string} verdict
 */

/**
 * @typedef {object} Exercise  telex_msgs/TrainingExercise
 * @property {string} name
 * @property {string} title
 * @property {string} description
 * @property {string[]} settings
 * @property {string[]} modes
 * @property {number} best
 * @property {string} preview
 * @property {string} problem
 */

export class TrainingClient {
  /** @param {import("../robot_client.js").RobotClient} robot */
  constructor(robot) {
    this._robot = robot;
  }

  /**
   * @param {(state: State) => void} heard
   * @param {string} [topic]  Global; left out: what the shown robot is told.
   */
  subscribe(heard, topic = this._robot.topic("training/state")) {
    /** @type {State | null} */
    let last = null;
    this._robot.bridge.subscribe({ topic, type: TYPES.state, throttle: 100, heard: (state) => heard(last = state) });
    onLanguage(() => last !== null && heard(last));
  }

  /**
   * Call a service of the training node; a refusal is shown as a warning.
   * @param {string} name  Of the service below `training/`.
   * @param {object} [args]
   * @returns {Promise<boolean>} Whether it was done.
   */
  async act(name, args = {}) {
    return (await this._robot.request(`training/${name}`, args, undefined, SLOW)) !== null;
  }

  /** @param {string} operator @returns {Promise<Exercise[]>} */
  async list(operator) {
    const { exercises } = await this._robot.call("training/list", { operator }, SLOW);
    return exercises;
  }
}

/** Who sits here, as was typed last. */
export function rememberedOperator() {
  return storage.getItem(OPERATOR) ?? "";
}

/** @param {string} name */
export function rememberOperator(name) {
  storage.setItem(OPERATOR, name);
}

/**
 * Address of a page or picture of the training, with what this page's own address says of who looks.
 * @param {string} path
 * @param {URLSearchParams} given
 * @param {Record<string, string>} [more]
 */
export function addressOf(path, given, more = {}) {
  const query = new URLSearchParams(more);
  for (const key of ["token", "role"]) if (given.has(key)) query.set(key, given.get(key) ?? "");
  return query.size === 0 ? path : `${path}?${query}`;
}

/** @param {number} seconds */
export function clockText(seconds) {
  const whole = Math.max(0, Math.floor(seconds));
  return `${String(Math.floor(whole / 60)).padStart(2, "0")}:${String(whole % 60).padStart(2, "0")}`;
}
