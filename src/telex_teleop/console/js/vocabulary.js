// @ts-check
/** What an operator can do, by which key and under which title, as the video server tells it (config/actions.yaml). */

import { text } from "./language.js";
import { whichRobot } from "./robot.js";

const ADDRESS = "/actions.json";
const RETRY_AFTER = 2000; // ms

/**
 * @typedef {{kind: "jog", node: string, joints: string[], sign: 1 | -1}} Jog  Moves joints while it is held; the chosen side
 *   decides which flippers move.
 * @typedef {{kind: "drive", linear: number, angular: number}} Drive  Drives the tracks while it is held.
 * @typedef {{kind: "side", name: "left" | "right"}} Side  Restricts flipper motions to one side while it is held.
 * @typedef {{kind: "preset", name: string, index: number}} Preset  Moves the flippers to a preset while it is held: to that with
 *   this place in the list that the robot announces.
 * @typedef {{kind: "tool", axis: "x" | "y" | "z" | "roll" | "pitch" | "yaw", sign: 1 | -1}} Tool  Moves the tool along or about an
 *   axis of the chosen frame, in CARTESIAN mode.
 * @typedef {{kind: "pose", name: string}} Pose  Moves the arm to a named pose while it is held.
 * @typedef {{kind: "zoom", sign: 1 | -1}} Zoom  Changes the zoom of the camera while it is held.
 * @typedef {{kind: "lamps", names: string[]}} Lamps  Switches lamps together, by a press.
 * @typedef {{kind: "command", name: string}} Command  Is done once by a press.
 * @typedef {Jog | Drive | Side | Preset | Tool | Pose | Zoom | Lamps | Command} Does
 * @typedef {Does & {amount?: number}} Demand  `amount`: how far it is held, 0 to 1 (default).
 *
 * @typedef {"DRIVE" | "JOINT" | "CARTESIAN" | "CAMERA"} Mode
 *
 * @typedef {object} Action
 * @property {string} name           By which the page keeps a user's own key.
 * @property {Does} does
 * @property {string} title          In the list of keys.
 * @property {string} label          On its button.
 * @property {string} row            Before its buttons.
 * @property {string} group          In the list of keys.
 * @property {Mode[]} modes          In which it has its key.
 * @property {string | null} code    Position of its key (KeyboardEvent.code); null: it has none in the page.
 * @property {string | null} cap     What a US keyboard shows there.
 * @property {string[]} more_codes   Further keys, which are not to be edited.
 * @property {boolean} button        Whether the page has a button for it; there may be one without a key.
 *
 * @typedef {object} Told
 * @property {number} speed_step     Of the full speed.
 * @property {number} zoom_rate      1/s, of the zoom factor's logarithm.
 * @property {number} max_zoom       Until the robot has said how far its camera zooms.
 * @property {string[]} lengths      Joints that are shown in mm.
 * @property {{name: Mode, note: string}[]} modes
 * @property {Layout[]} layouts
 * @property {Action[]} actions
 *
 * @typedef {object} Layout  Of the page.
 * @property {string} name
 * @property {Mode[]} modes      In which it is there.
 * @property {string[]} first    Cameras of the first view: the first one that the robot has.
 * @property {string[]} second   Of the second one.
 * @property {string[]} [aids]    Commands of the aids that are on at first.
 */

/** @type {Mode[]} */
const MODES = ["DRIVE", "JOINT", "CARTESIAN", "CAMERA"];

/** Vocabulary of a page that got none: the emergency stop must have its key in any case. @type {Told} */
const NOTHING = {
  speed_step: 0, zoom_rate: 0, max_zoom: 1, lengths: [], modes: MODES.map((name) => ({ name, note: "" })),
  layouts: [{ name: "LOOK", modes: MODES, first: [], second: [] }],
  actions: [{
    name: "estop", does: { kind: "command", name: "e-stop" }, title: "e-stop", label: "e-stop", row: "", group: "Always", modes: MODES,
    code: "Escape", cap: "Esc", more_codes: [], button: true,
  }],
};

/** What tells an action from all others. @param {any} does */
function identity({ kind, node, joints, names, axis, sign, linear, angular, name }) {
  // The order of joints and lamps is the file's.
  return JSON.stringify([kind, node, joints?.slice().sort(), names?.slice().sort(), axis, sign, linear, angular, name]);
}

export class Vocabulary {
  /** @param {Told} told */
  constructor(told) {
    this.speedStep = told.speed_step;
    this.zoomRate = told.zoom_rate;
    this.maxZoom = told.max_zoom;
    this.lengths = new Set(told.lengths);
    this.modes = told.modes;
    this.layouts = told.layouts;
    this.all = told.actions;
    this._byName = new Map(this.all.map((action) => [action.name, action]));
    // Of two that do the same in different modes, the first one.
    this._nameBy = new Map(this.all.slice().reverse().map(({ name, does }) => [identity(does), name]));
    /** In which the page begins. @type {Mode} */
    this.firstMode = told.layouts?.[0]?.modes[0] ?? "DRIVE";
    this.presets = this.find("preset");
    this.presets.forEach(({ does }, index) => { does.index = index; });
  }

  /** @param {string} name */
  get(name) {
    return this._byName.get(name);
  }

  /**
   * Actions of a kind, in their order.
   * @template {Does["kind"]} Kind
   * @param {Kind} kind
   * @returns {(Action & {does: Extract<Does, {kind: Kind}>})[]}
   */
  find(kind) {
    return /** @type {any[]} */ (this.all.filter(({ does }) => does.kind === kind));
  }

  /** Name of the emergency stop, whose key nobody can change. */
  get emergencyStop() {
    return this.nameOf({ kind: "command", name: "e-stop" }, []);
  }

  /** Joints of the flippers, in their order. @returns {string[]} */
  get flippers() {
    return [...new Set(this.find("jog").flatMap(({ does }) => (does.node === "flipper" ? does.joints : [])))];
  }

  /**
   * Name of the action that does something; empty if there is none.
   * @param {any} does        As /joy_map.json has it.
   * @param {string[]} presets  Names of the flippers' presets, as the robot announces them.
   */
  nameOf(does, presets) {
    if (does.kind === "preset") return this.presets[presets.indexOf(does.name)]?.name ?? "";
    return this._nameBy.get(identity(does)) ?? "";
  }
}

/** @param {URLSearchParams} given  Of this page: which robot counts. */
async function ask(given) {
  const reply = await fetch(`${ADDRESS}?${whichRobot(given)}`, { cache: "no-store" });
  if (!reply.ok) throw new Error(`the video server says ${reply.status}`);
  return new Vocabulary(await reply.json());
}

/**
 * Ask for the vocabulary; without one, a page still has pictures and the emergency stop, and reloads as soon as there is one.
 * @param {URLSearchParams} given
 * @returns {Promise<{vocabulary: Vocabulary, problem: string}>} `problem`: why nothing can be done, else empty.
 */
export async function fetchVocabulary(given) {
  try {
    return { vocabulary: await ask(given), problem: "" };
  } catch (error) {
    const retry = () => ask(given).then(() => location.reload(), () => setTimeout(retry, RETRY_AFTER));
    setTimeout(retry, RETRY_AFTER);
    const why = /** @type {Error} */ (error).message;
    return { vocabulary: new Vocabulary(NOTHING), problem: text("NO KEYS: {address} cannot be read ({why}). Nothing can be moved; the e-stop works. Retrying …", { address: ADDRESS, why }) };
  }
}
