// @ts-check
/** The side panel: joints with their values and the buttons that move them. */

import {
  ACTIONS, ARM_JOINTS, FINGER_BASES, GRIPPER_JOINT, PRESET_KEYS, fingerJoints, flipperJoints,
} from "./robot.js";

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
 * @param {string} [text]
 */
export function element(tag, className = "", text = "") {
  const made = document.createElement(tag);
  made.className = className;
  made.textContent = text;
  return made;
}

/** @param {string} name  Of an action. */
export function holdButton(name) {
  const action = ACTIONS[name];
  const button = /** @type {HTMLButtonElement} */ (element("button", "hold"));
  button.type = "button";
  button.tabIndex = -1;
  button.dataset.action = name;
  const cap = element("kbd", "", action.cap);
  cap.dataset.code = action.code;
  const arrow = ARROWS[action.label];
  button.append(cap, arrow === undefined ? action.label : `${arrow} ${action.label}`);
  return button;
}

/** @param {string} joint */
function valueOf(joint) {
  const value = element("span", "num", "–");
  value.dataset.joint = joint;
  return value;
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

export class Panels {
  constructor() {
    const pair = (/** @type {string} */ name, /** @type {string[]} */ ways) =>
      ways.map((way) => holdButton(`${name}:${way}`));
    byId("drive-pad").append(...pair("drive", ["forward", "left", "back", "right"]));
    for (const { name, label } of ARM_JOINTS) {
      const motion = name.replace(/_joint$/, "");
      const ways = Object.keys(ACTIONS).filter((key) => key.startsWith(`${motion}:`)).map((key) => key.split(":")[1]);
      byId("arm-rows").append(row("", label, valueOf(name), ...pair(motion, ways)));
    }
    byId("gripper-rows").append(
      row("", "opening", valueOf(GRIPPER_JOINT), ...pair("gripper", ["close", "open"])),
      row("wide", "fingers", ...["left", "right"].map((side) => cell(...spaced(fingerJoints(side).map(valueOf))))),
    );
    for (const end of ["front", "rear"]) {
      const [left, right] = flipperJoints(end).map(valueOf);
      byId("flipper-rows").append(row("pair", end, cell("L ", left, "  R ", right), ...pair(end, ["up", "down"])));
    }
    this._presets = Array.from({ length: PRESET_KEYS }, (_, index) => holdButton(`preset:${index}`));
    byId("flipper-presets").append(...this._presets);
    this.showPresets([], []);
    this._values = [.../** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll("[data-joint]"))];
    this._metres = new Set(ARM_JOINTS.filter(({ metres }) => metres).map(({ name }) => name));
    /** @type {Map<string, number>} */
    this._positions = new Map();
    /** Joints held back by a limit, by node. @type {Map<string, string[]>} */
    this._limited = new Map();
  }

  /** @param {any} states  sensor_msgs/JointState */
  showJoints(states) {
    states.name.forEach((/** @type {string} */ name, /** @type {number} */ index) => {
      this._positions.set(name, states.position[index]);
    });
    const bases = FINGER_BASES.map((base) => this._positions.get(base));
    if (bases.every(Number.isFinite)) {
      const sum = /** @type {number[]} */ (bases).reduce((total, angle) => total + angle, 0);
      this._positions.set(GRIPPER_JOINT, sum / bases.length);
    }
    for (const value of this._values) {
      const joint = /** @type {string} */ (value.dataset.joint);
      value.textContent = this._format(joint, this._positions.get(joint));
    }
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
    for (const button of /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll("[data-action]"))) {
      button.classList.toggle("held", actions.has(/** @type {string} */ (button.dataset.action)));
    }
  }

  /** @param {"left" | "both" | "right"} side */
  showSide(side) {
    for (const button of /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll("[data-side]"))) {
      button.setAttribute("role", "radio");
      button.setAttribute("aria-checked", String(button.dataset.side === side));
    }
  }

  /**
   * @param {string[]} names         Of the robot's flipper presets, in the order of their keys.
   * @param {string[]} descriptions  What each of them is for.
   */
  showPresets(names, descriptions) {
    this._presets.forEach((button, index) => {
      button.hidden = index >= names.length;
      button.title = descriptions[index] ?? "";
      /** @type {Text} */ (button.lastChild).data = names[index] ?? "";
    });
  }

  /** @param {any} twist  What goes to the tracks now, geometry_msgs/Twist. */
  showDrive(twist) {
    const forward = `${signed(twist.linear.x, 2)} m/s`;
    const turn = `${signed((twist.angular.z * 180) / Math.PI, 0)} °/s`;
    byId("drive-linear").textContent = forward;
    byId("drive-angular").textContent = turn;
    byId("drive-hud").textContent = `${forward}  ${turn}`;
  }

  /**
   * @param {string} joint
   * @param {number | undefined} position  rad or m
   */
  _format(joint, position) {
    if (position === undefined || position === null) return "–";
    if (this._metres.has(joint)) return `${fixed(position * 1000, 0)} mm`;
    return `${fixed((position * 180) / Math.PI, joint.includes("finger") ? 0 : 1)}°`;
  }
}

/**
 * @param {HTMLElement[]} values
 * @returns {(HTMLElement | Text)[]}
 */
function spaced(values) {
  return values.flatMap((value, index) => (index > 0 ? [document.createTextNode("  "), value] : [value]));
}

/**
 * A number with so many digits after the point, and no "-0".
 * @param {number} value
 * @param {number} digits
 */
export function fixed(value, digits) {
  const text = value.toFixed(digits);
  return Number(text) === 0 ? text.replace("-", "") : text;
}

/**
 * The same with its sign, also when it is positive.
 * @param {number} value
 * @param {number} digits
 */
function signed(value, digits) {
  const text = fixed(value, digits);
  return Number(text) > 0 ? `+${text}` : text;
}
