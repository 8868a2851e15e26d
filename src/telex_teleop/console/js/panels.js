// @ts-check
/** The side panel: joints with their values and the buttons that move them. */

import { makeButton } from "./buttons.js";
import { decimal, text, translated } from "./language.js";

const ARROWS = /** @type {Record<string, string>} */ ({
  ahead: "▲", back: "▼", up: "▲", down: "▼", left: "◀", right: "▶", in: "◀", out: "▶", close: "▶◀", open: "◀▶",
});

/**
 * @param {string} id
 * @returns {HTMLElement}
 */
export function byId(id) {
  const element = document.getElementById(id);
  if (element === null) throw new Error(`the page has no element ${id}`);
  return element;
}

/**
 * @param {string} tag
 * @param {string} [className]
 * @param {string} [words]
 */
export function element(tag, className = "", words = "") {
  const made = document.createElement(tag);
  made.className = className;
  made.textContent = words;
  return made;
}

/**
 * Elements of the page, or of a part of it.
 * @param {string} selector
 * @param {ParentNode} [root]
 */
export const all = (selector, root = document) => /** @type {NodeListOf<HTMLElement>} */ (root.querySelectorAll(selector));

/**
 * Show which of some buttons are chosen.
 * @param {Iterable<HTMLElement>} buttons
 * @param {(button: HTMLElement) => boolean} isChosen
 */
export function check(buttons, isChosen) {
  for (const button of buttons) button.setAttribute("aria-checked", String(isChosen(button)));
}

/** A key cap, which shows the key that an action has. @param {string} action */
export function keyCap(action) {
  const cap = element("kbd");
  cap.dataset.binding = action;
  return cap;
}

/**
 * Write a text unless it is there already, for it would be laid out again.
 * @param {Element} where
 * @param {string} words
 */
export function setText(where, words) {
  if (where.textContent !== words) where.textContent = words;
}

/** @param {import("./vocabulary.js").Action} action */
export function holdButton({ name, label }) {
  const button = makeButton("", undefined, "hold");
  button.dataset.action = name;
  const arrow = ARROWS[label];
  // The words are a text node of their own, so that another language can replace them.
  button.append(keyCap(name), ...(arrow === undefined ? [text(label)] : [`${arrow} `, text(`${label}|arrow`)]));
  return button;
}

/**
 * Actions that share a row, row after row: those with the same first part of the name.
 * @template {import("./vocabulary.js").Action} Action
 * @param {Action[]} actions
 */
export function rowsOf(actions) {
  /** @type {Map<string, Action[]>} */
  const rows = new Map();
  for (const action of actions) {
    const key = action.name.split(":")[0];
    rows.set(key, [...(rows.get(key) ?? []), action]);
  }
  return [...rows.values()];
}

/**
 * A joint's value over a bar that shows where it is between its limits.
 * @param {string} joint
 */
function valueOf(joint) {
  const value = element("span", "num", "–");
  value.dataset.joint = joint;
  const bar = element("i", "bar");
  bar.dataset.bar = joint;
  bar.append(element("i", "bar-fill"), element("i", "bar-mark"));
  const made = element("span", "joint");
  made.append(value, bar);
  return made;
}

/**
 * @param {string} className
 * @param {(string | Node)[]} cells
 */
export function row(className, ...cells) {
  const made = element("div", `row ${className}`);
  made.append(...cells.map((cell) => (typeof cell === "string" ? element("span", "", cell) : cell)));
  return made;
}

/** @param {(string | Node)[]} nodes */
function cell(...nodes) {
  const made = element("span", "num");
  made.append(...nodes);
  return made;
}

/** Share of a joint's way within which its end counts as near. */
const NEAR = 0.1;

/** Least share of the bar that what is beyond a soft limit takes: less could not be seen. */
const VISIBLE = 0.03;

export class Panels {
  /**
   * @param {import("./joints.js").JointPositions} joints
   * @param {import("./vocabulary.js").Vocabulary} vocabulary
   * @param {import("./robot.js").Facts} facts
   */
  constructor(joints, vocabulary, { gripper, moves, sides }) {
    this._joints = joints;
    this._gripper = gripper;
    const fingers = moves?.gripper ?? [];
    /** Joints whose position needs no digits after the point. */
    this._coarse = new Set(fingers);
    this._jogs = vocabulary.find("jog");
    /** What each node was last said to move. @type {Map<string, string>} */
    this._moved = new Map();
    const jogs = this._jogs.filter(({ button }) => button);
    const inModes = (/** @type {string} */ node, /** @type {string} */ modes) =>
      rowsOf(jogs.filter((action) => action.does.node === node && (modes === "" || action.modes.join() === modes)));
    /** @param {string} id  @param {import("./vocabulary.js").Action[]} actions  @param {(string | Node)[]} values */
    const add = (id, actions, ...values) => byId(id).append(row("", text(actions[0].row), ...values, ...actions.map(holdButton)));
    byId("drive-pad").append(...vocabulary.find("drive").map(holdButton));
    for (const actions of inModes("arm", "JOINT")) add("arm-rows", actions, valueOf(actions[0].does.joints[0]));
    for (const actions of inModes("arm", "CAMERA")) add("camera-rows", actions, valueOf(actions[0].does.joints[0]));
    for (const actions of inModes("gripper", "")) add("gripper-rows", actions, valueOf(gripper?.name ?? actions[0].does.joints[0]));
    const onSides = [sides.left, sides.right].map((each) => fingers.filter((joint) => each.includes(joint)));
    const others = fingers.filter((joint) => !onSides.flat().includes(joint));
    const shown = [...onSides, others].filter((each) => each.length > 0);
    if (shown.length > 0) byId("gripper-rows").append(row("wide", text("fingers"), ...shown.map((each) => cell(...each.map(valueOf)))));
    for (const actions of inModes("flipper", "")) {
      const values = actions[0].does.joints.flatMap((joint) => [sides.left.includes(joint) ? text("L") : sides.right.includes(joint) ? text("R") : "", valueOf(joint)]);
      byId("flipper-rows").append(row("pair", text(actions[0].row), cell(...values), ...actions.map(holdButton)));
    }
    this._presets = vocabulary.presets.map(holdButton);
    byId("flipper-presets").append(...this._presets);
    this.showPresets([], []);
    this._values = [...all("[data-joint]")];
    this._lengths = vocabulary.lengths;
    this._bars = [...all("[data-bar]")];
    /** @type {import("./urdf.js").RobotModel | null} */
    this._model = null;
    /** Joints held back by a limit, by node. @type {Map<string, string[]>} */
    this._limited = new Map();
  }

  /** @param {import("./urdf.js").RobotModel} model  Says what the limits are. */
  setModel(model) {
    this._model = model;
    for (const bar of this._bars) {
      const limits = this._limits(bar);
      bar.classList.toggle("limits", limits !== null);
      if (limits === null) continue;
      const span = limits.upper - limits.lower;
      const percent = (/** @type {number} */ share) => `${(100 * Math.max(VISIBLE, share)).toFixed(1)}%`;
      bar.style.setProperty("--lower", percent((limits.softLower - limits.lower) / span));
      bar.style.setProperty("--upper", percent((limits.upper - limits.softUpper) / span));
    }
  }

  /** Show where the joints are. */
  showJoints() {
    for (const value of this._values) setText(value, this.format(/** @type {string} */ (value.dataset.joint)));
    for (const bar of this._bars) {
      const limits = this._limits(bar);
      const position = this._joints.position(/** @type {string} */ (bar.dataset.bar));
      if (limits === null || !Number.isFinite(position)) continue;
      const { lower, upper, softLower, softUpper } = limits;
      const share = (/** @type {number} */ at) => Math.min(1, Math.max(0, (at - lower) / (upper - lower)));
      const at = share(/** @type {number} */ (position)), zero = share(0);
      // A joint without a soft limit, such as one that slides, may well rest at its end.
      const isBeyond = at > share(softUpper) || at < share(softLower);
      const state = isBeyond ? "end" : at < NEAR || at > 1 - NEAR ? "near" : "free";
      if (bar.dataset.state !== state) bar.dataset.state = state;
      const now = at.toFixed(3);
      if (bar.dataset.at === now) continue;
      bar.dataset.at = now;
      const [fill, mark] = /** @type {HTMLCollectionOf<HTMLElement>} */ (bar.children);
      fill.style.left = `${(100 * Math.min(at, zero)).toFixed(1)}%`;
      fill.style.width = `${(100 * Math.abs(at - zero)).toFixed(1)}%`;
      mark.style.left = `${(100 * at).toFixed(1)}%`;
    }
  }

  /** @param {HTMLElement} bar */
  _limits(bar) {
    const joint = /** @type {string} */ (bar.dataset.bar);
    return this._model?.limits(joint === this._gripper?.name ? this._gripper.measured_by[0] : joint) ?? null;
  }

  /**
   * Leave out what the robot does not have, here and in the list of keys.
   * @param {string} node
   * @param {string[]} joints  All that it moves.
   */
  showMoved(node, joints) {
    if (this._moved.get(node) === joints.join()) return;
    this._moved.set(node, joints.join());
    for (const { name, does } of this._jogs) {
      if (`${does.node}_teleop` !== node) continue;
      // One joint may stand for all joints of a gripper.
      const isThere = does.joints.some((joint) => joints.includes(joint)) || (does.node === "gripper" && joints.length > 0);
      for (const each of all(`[data-action="${name}"], [data-key="${name}"]`)) {
        (/** @type {HTMLElement | null} */ (each.closest(".row")) ?? each).hidden = !isThere;
      }
    }
    const card = { gripper_teleop: "gripper-card", flipper_teleop: "flipper-card" }[node];
    const isKnown = this._jogs.some(({ does }) => `${does.node}_teleop` === node);
    if (card !== undefined) byId(card).hidden = joints.length === 0 || !isKnown;
  }

  /**
   * @param {string} node
   * @param {string[]} joints  Those whose motion a limit holds back now.
   */
  showLimited(node, joints) {
    this._limited.set(node, joints);
    const limited = new Set([...this._limited.values()].flat());
    for (const value of this._values) {
      value.classList.toggle("limited", limited.has(/** @type {string} */ (value.dataset.joint)));
    }
  }

  /** @param {Set<string>} actions  Those that are held. */
  showHeld(actions) {
    for (const button of all("[data-action]")) {
      button.classList.toggle("held", actions.has(/** @type {string} */ (button.dataset.action)));
    }
  }

  /** @param {"left" | "both" | "right"} side */
  showSide(side) {
    check(all("[data-side]"), ({ dataset }) => dataset.side === side);
  }

  /**
   * @param {string[]} names         Of the robot's flipper presets, in the order of their keys.
   * @param {string[]} descriptions  What each of them is for.
   */
  showPresets(names, descriptions) {
    this._presets.forEach((button, index) => {
      button.hidden = index >= names.length;
      button.title = translated(descriptions[index] ?? "");
      /** @type {Text} */ (button.lastChild).data = translated(names[index] ?? "");
    });
  }

  /** A joint's position as text. @param {string} joint */
  format(joint) {
    const position = this._joints.position(joint);
    if (position === undefined || position === null) return "–";
    if (this._lengths.has(joint)) return `${fixed(position * 1000, 0)} mm`;
    return `${fixed((position * 180) / Math.PI, this._coarse.has(joint) ? 0 : 1)}°`;
  }
}

/**
 * Speed and turn rate of the base as texts.
 * @param {any} twist  geometry_msgs/Twist
 */
export function showTwist({ linear, angular }) {
  if (![linear.x, angular.z].every(Number.isFinite)) return ["–", "–"];
  return [`${signed(linear.x, 2)} m/s`, `${signed((angular.z * 180) / Math.PI, 0)} °/s`];
}

/**
 * A number with so many digits after the point, and no "-0".
 * @param {number} value
 * @param {number} digits
 */
export function fixed(value, digits) {
  return decimal(value, digits);
}

/**
 * The same with its sign, also when it is positive.
 * @param {number} value
 * @param {number} digits
 */
function signed(value, digits) {
  return `${Number(value.toFixed(digits)) > 0 ? "+" : ""}${fixed(value, digits)}`;
}
