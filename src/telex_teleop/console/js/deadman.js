// @ts-check
/** Detects that the operator may no longer be in control of the page. */

import { decimal, text } from "./language.js";

/** A tick (ms) that comes later than this says that the page hung or slept; a press that old was meant for another moment. */
const MAX_GAP = 200;

/** Time (ms) between two questions to the browser, each of which costs its main process and the page as much as a command. */
const ASK_PERIOD = 50;

/** When the page's clock last ticked (ms). */
let ticked = Infinity;

/**
 * Whether the page has been standing still until just now: what was held before may have been let go unseen.
 * @param {number} [now]  ms
 */
export const stoodStill = (now = performance.now()) => now - ticked > MAX_GAP;

/**
 * Whether an event has waited so long that it must not be acted upon.
 * @param {Event} event
 */
export const isStale = (event) => performance.now() - event.timeStamp > MAX_GAP;

/** A message to oneself, which only the browser's main process can deliver. */
const askBrowser = (() => {
  const name = `telex.deadman.${performance.timeOrigin}.${Math.random()}`;
  const question = new BroadcastChannel(name);
  const answer = new BroadcastChannel(name);
  /** @param {() => void} answered */
  return (answered) => {
    answer.onmessage = answered;
    question.postMessage(null);
  };
})();

/** When the last question was asked (ms), and whether it has been answered. */
let asked = -Infinity, answered = true;

/**
 * Whether the browser's main process does not answer, through which the page hears that a key is let go. Call at a steady pace while
 * something is held.
 */
export function browserHangs() {
  const since = performance.now() - asked;
  if (!answered) return since > MAX_GAP;
  if (since < ASK_PERIOD) return false;
  asked = performance.now();
  answered = false;
  askBrowser(() => {
    answered = true;
  });
  return false;
}

/**
 * Watch for everything after which held keys must be released.
 * @param {(reason: string) => void} letGo
 */
export function watchOperator(letGo) {
  window.addEventListener("blur", () => letGo(text("the window lost the focus")));
  window.addEventListener("pagehide", () => letGo(text("the page was left")));
  document.addEventListener("freeze", () => letGo(text("the page was frozen")));
  document.addEventListener("visibilitychange", () => {
    if (document.hidden) letGo(text("the page was hidden"));
  });
}

/**
 * Call back at a steady pace, and tell when the pace was not kept.
 * @param {number} period  ms
 * @param {() => void} tick
 * @param {(reason: string) => void} letGo
 */
export function keepPace(period, tick, letGo) {
  ticked = performance.now();
  setInterval(() => {
    // The time is read once: a standstill between two readings would be seen by neither.
    const now = performance.now();
    const gap = now - ticked;
    ticked = now;
    if (gap > MAX_GAP) letGo(text("the page stood still for {seconds} s", { seconds: decimal(gap / 1000, 1) }));
    tick();
  }, period);
}
