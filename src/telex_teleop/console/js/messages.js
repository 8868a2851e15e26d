// @ts-check
/** The log of messages: each message once, with its severity. */

import { onClick } from "./buttons.js";
import { translated } from "./language.js";
import { all, byId, check, element } from "./panels.js";

/** @typedef {"info" | "warning" | "alarm"} Level */

/** Signs of the levels, so that colour is not their only mark. */
const MARKS = { info: "·", warning: "!", alarm: "✖" };

const KEPT = 60; // lines
const REPEATED_WITHIN = 30_000; // ms within which the same sentence is the same message
const GOES_ON_WITHIN = 1000; // ms within which a repetition is not counted again

/**
 * Time (ms) for which a complaint waits for others of the same words, and for the simulator to say the same itself: nodes and simulator
 * hear of an e-stop at nearly the same time.
 */
const GATHERED_FOR = 400;

/** @typedef {{sentence: string, level: Level, at: number, count: number, line: HTMLElement}} Entry  `sentence` without its figures. */

/** What two sentences have in common that differ in their figures. @param {string} sentence */
const figureless = (sentence) => sentence.replace(/[\d.]+/g, "#");

export class Messages {
  constructor() {
    this._list = byId("log");
    /** The newest first. @type {Entry[]} */
    this._entries = [];
    /** What each node complains of. @type {Map<string, string>} */
    this._complaints = new Map();
    /** Complaints that have not been logged yet: when they came, by node. @type {Map<string, number>} */
    this._gathered = new Map();
    const buttons = all("[data-least]");
    for (const button of buttons) {
      onClick(button, () => {
        check(buttons, (each) => each === button);
        this._list.dataset.shows = button.dataset.least;
      });
    }
  }

  /**
   * @param {string} sentence
   * @param {Level} [level]
   */
  add(sentence, level = "info") {
    const now = performance.now();
    const words = figureless(sentence);
    // A change of state is logged every time; a warning that repeats is one message until it is old.
    const among = level === "warning" ? this._entries : this._entries.slice(0, 1);
    const before = among.find((each) => each.sentence === words && each.level === level && now - each.at < REPEATED_WITHIN);
    if (before !== undefined) this._entries.splice(this._entries.indexOf(before), 1);
    const line = before?.line ?? element("li");
    const count = before === undefined ? 1 : now - before.at < GOES_ON_WITHIN ? before.count : before.count + 1;
    line.title = sentence;
    line.dataset.level = level;
    line.dataset.count = String(count);
    const text = element("span", "sentence", sentence);
    if (count > 1) text.append(element("b", "num", ` ×${count}`));
    line.replaceChildren(
      element("span", "num", new Date().toTimeString().slice(0, 8)), element("b", "mark", MARKS[level]), text,
    );
    this._list.prepend(line);
    this._entries.unshift({ sentence: words, level, at: now, count, line });
    for (const old of this._entries.splice(KEPT)) old.line.remove();
  }

  /**
   * Take what a node complains of now.
   * @param {string} node
   * @param {string} sentence  Empty if it complains of nothing.
   */
  complain(node, sentence) {
    if (figureless(this._complaints.get(node) ?? "") === figureless(sentence)) return;
    this._complaints.set(node, sentence);
    if (sentence) this._gathered.set(node, performance.now());
    else this._gathered.delete(node);
  }

  /**
   * Log the complaints that have been gathered, those of the same words in one line. Call it every now and then.
   * @param {(sentence: string) => boolean} isKnown  Whether the simulator has said so itself.
   */
  settle(isKnown) {
    const due = performance.now() - GATHERED_FOR;
    if (![...this._gathered.values()].some((at) => at < due)) return;
    /** @type {Map<string, string[]>} */
    const nodes = new Map();
    for (const node of this._gathered.keys()) {
      const sentence = /** @type {string} */ (this._complaints.get(node));
      nodes.set(sentence, [...(nodes.get(sentence) ?? []), node]);
    }
    this._gathered.clear();
    for (const [sentence, who] of nodes) if (!isKnown(sentence)) this.add(`${who.sort().join(", ")}: ${translated(sentence)}`, "warning");
  }
}
