// @ts-check
/** What moves now and who moves it, as the robot's nodes report. */

import { term, text, translated } from "./language.js";
import { FLIPPER_NODE, TRACK_NODE } from "./robot.js";
import { byId, setText } from "./panels.js";

/** What the nodes move. @type {Record<string, string>} */
const PARTS = { [TRACK_NODE]: term("base"), [FLIPPER_NODE]: term("flippers"), arm_teleop: term("arm"), gripper_teleop: term("gripper") };

/** What the page calls the sources of what is held. @type {Record<string, string>} */
const INPUTS = { key: term("keys"), pointer: term("buttons"), pad: term("gamepad") };

const SILENT_AFTER = 1000; // ms after which a node's report no longer counts

/** Time (ms) for which a device is shown after it was obeyed, so that two that alternate are both shown. */
const SHOWN_FOR = 600;

/** @typedef {import("./vocabulary.js").Action} Action */
/** @typedef {{source: string, name: string, action: Action}} Hold */

/**
 * The node that an action commands; undefined: none that reports whether it obeys.
 * @param {Action} action
 */
function nodeOf({ does }) {
  if (does.kind === "jog") return `${does.node}_teleop`;
  return /** @type {Record<string, string>} */ ({ drive: TRACK_NODE, preset: FLIPPER_NODE, tool: "arm_teleop", pose: "arm_teleop" })[does.kind];
}

/**
 * @param {Hold} hold
 * @param {string[]} presets
 * @param {(joint: string) => string} format  A joint's position.
 * @param {"left" | "both" | "right"} side  Of the flippers, which moves.
 */
function describe({ action: { does, title } }, presets, format, side) {
  // The robot may have other presets than the list of actions.
  if (does.kind === "preset") return text("flippers to {preset}", { preset: translated(presets[does.index] ?? does.name) });
  if (does.kind !== "jog") return text(title);
  if (does.node === "flipper") return text(side === "both" ? title : title.replace("flippers", `${side} flipper`));
  return does.node === "arm" ? `${text(title)} ${format(does.joints[0])}` : text(title);
}

export class Motion {
  /**
   * @param {import("./control.js").ControlView} control
   * @param {(device: string) => void} joined  Told of a device that moves the robot past the bridge, when it begins.
   */
  constructor(control, joined) {
    this._control = control;
    this._joined = joined;
    /** Whose commands each node obeys. @type {Map<string, {at: number, commanders: string[]}>} */
    this._nodes = new Map();
    /** When devices other than the bridge were obeyed last. @type {Map<string, number>} */
    this._devices = new Map();
    this._bridgeObeyed = -Infinity;
  }

  /**
   * @param {string} node
   * @param {{commanders?: string[]}} status  telex_msgs/JointTeleopStatus or TrackTeleopStatus
   */
  hear(node, { commanders = [] }) {
    const now = performance.now();
    this._nodes.set(node, { at: now, commanders });
    for (const commander of commanders) {
      const name = commander.slice(commander.lastIndexOf("/") + 1);
      if (name === "rosbridge") {
        this._bridgeObeyed = now;
        continue;
      }
      const device = deviceOf(name);
      if (now - (this._devices.get(device) ?? -Infinity) > SHOWN_FOR) this._joined(device);
      this._devices.set(device, now);
    }
  }

  /**
   * Show it, over the picture and above.
   * @param {Hold[]} held  On this page.
   * @param {string[]} presets  Names of the flipper presets.
   * @param {(joint: string) => string} format  A joint's position.
   * @param {"left" | "both" | "right"} side  Of the flippers, which moves.
   */
  show(held, presets, format, side) {
    const now = performance.now();
    const moving = Object.keys(PARTS).filter((node) => {
      const said = this._nodes.get(node);
      return said !== undefined && said.commanders.length > 0 && now - said.at < SILENT_AFTER;
    });
    const parts = moving.flatMap((node) => {
      const own = held.filter(({ action }) => nodeOf(action) === node).map((each) => describe(each, presets, format, side));
      return own.length > 0 ? own : [text(PARTS[node])];
    });
    const zoomed = held.filter(({ action }) => action.does.kind === "zoom").map(({ action }) => text(action.title));
    setText(byId("moves"), [...new Set([...parts, ...zoomed])].join(", ") || "–");
    const others = [...this._devices].filter(([, at]) => now - at < SHOWN_FOR).map(([device]) => device);
    const isObeyed = moving.length > 0 && now - this._bridgeObeyed < SHOWN_FOR;
    setText(byId("moved-by"), [...(isObeyed || zoomed.length > 0 ? [this._client(held)] : []), ...others].join(", ") || "–");
    const chip = byId("others");
    chip.hidden = others.length === 0;
    setText(chip, text("MOVED BY {devices}", { devices: others.join(", ") }));
    chip.title = chip.textContent ?? "";
  }

  /** Who commands through the bridge. @param {Hold[]} held */
  _client(held) {
    if (!this._control.isMine) return this._control.holderName;
    const inputs = new Set(held.map(({ source }) => text(INPUTS[source.split(":")[0]])));
    if (inputs.size > 0) return text("you ({inputs})", { inputs: [...inputs].join(", ") });
    return this._control.isKnown ? text("you") : text("a client of the bridge");
  }
}

/** @param {string} name  Of a node. */
function deviceOf(name) {
  if (name === "joy_teleop") return text("the robot's gamepad");
  if (name.startsWith("keyboard_teleop")) return text("a terminal");
  if (name === "goal") return text("a script");
  // rospy's anonymous nodes have numbers after their names
  return text("the program {name}", { name: name.replace(/(_\d+)+$/, "") });
}
