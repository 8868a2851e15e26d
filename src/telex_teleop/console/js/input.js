// @ts-check
/** From keys and pointers to held actions. */

import { isStale } from "./deadman.js";
import { text } from "./language.js";
import { printedKeys } from "./language/keyboard.js";
import { setText } from "./panels.js";

/** Actions that keys have also while something is typed, and while somebody walks the buttons. */
const ALWAYS = ["estop", "walk"], WALKING = [...ALWAYS, "stop"];

/** Whether a key belongs to a text that is typed, or to a list that is chosen from. @param {KeyboardEvent} event */
export function isTyped(event) {
  return event.target instanceof Element && event.target.matches("input, select, textarea");
}

/** Give keys to the browser, which walks from button to button by them; or take them back. */
export function walkButtons() {
  const at = document.activeElement;
  if (at instanceof HTMLElement && at !== document.body) return at.blur();
  const dialog = [...document.querySelectorAll("[role=dialog]")].find((each) => each instanceof HTMLElement && !each.hidden);
  /** @type {NodeListOf<HTMLElement>} */
  const buttons = (dialog ?? document).querySelectorAll("button:not(:disabled)");
  // One that is hidden takes no focus, and has no place on the page.
  [...buttons].find((each) => each.getClientRects().length > 0)?.focus(/** @type {any} */ ({ focusVisible: true }));
}

/** Whether a key may do something, or belongs to whatever has the focus. @param {KeyboardEvent} event  @param {string} name */
function isFree(event, name) {
  if (isTyped(event)) return ALWAYS.includes(name);
  return !document.activeElement?.matches("button:focus-visible, a:focus-visible") || WALKING.includes(name);
}

/**
 * Let keys hold actions, by their position on the keyboard.
 * @param {import("./held.js").Held} held
 * @param {() => boolean} mayPress  Whether actions can be held now.
 * @param {(code: string) => string | undefined} find  Name of the action that a key has now.
 * @param {(name: string) => (() => void) | undefined} commandOf  What an action does at once; undefined: it is held.
 * @param {(code: string) => boolean} takes  Whether something else wants this key.
 * @param {(reason: string) => void} letGo  Let go of everything.
 */
export function listenToKeys(held, mayPress, find, commandOf, takes, letGo) {
  // An open list keeps all keys to itself, also that they are let go.
  for (const kind of ["mousedown", "focusin"]) {
    window.addEventListener(kind, ({ target }) => {
      if (target instanceof Element && target.matches("select")) letGo(text("a list was opened"));
    }, { capture: true });
  }
  window.addEventListener("keydown", (event) => {
    // While this key is down, macOS does not tell that others are let go.
    if (event.metaKey || event.code.startsWith("Meta")) letGo(text("a key of the system was pressed"));
    if (event.ctrlKey || event.altKey || event.metaKey || event.isComposing) return;
    if (!event.repeat && takes(event.code)) {
      event.preventDefault();
      return;
    }
    const name = find(event.code);
    if (name === undefined || !isFree(event, name)) return;
    event.preventDefault();
    // A key that repeats was pressed before, perhaps before everything was released: that is no new press.
    if (event.repeat) return;
    const command = commandOf(name);
    if (command !== undefined) command();
    else if (!isStale(event) && mayPress()) held.press(`key:${event.code}`, name);
  }, { capture: true });
  window.addEventListener("keyup", (event) => {
    // Space on a focused button would click it.
    const name = find(event.code);
    if (name !== undefined && commandOf(name) !== undefined && isFree(event, name)) event.preventDefault();
    held.release(`key:${event.code}`);
  }, { capture: true });
}

/**
 * Let pointers hold the buttons that have a data-action.
 * @param {HTMLElement} root
 * @param {import("./held.js").Held} held
 * @param {() => boolean} mayPress
 */
export function listenToPointers(root, held, mayPress) {
  root.addEventListener("pointerdown", (event) => {
    const button = /** @type {Element} */ (event.target).closest("[data-action]");
    if (!(button instanceof HTMLElement) || event.button !== 0) return;
    event.preventDefault();
    if (isStale(event) || !mayPress()) return;
    button.setPointerCapture(event.pointerId);
    held.press(`pointer:${event.pointerId}`, /** @type {string} */ (button.dataset.action));
  });
  // A click must not move the focus: the keys go on driving. Only the keyboard moves it to a button.
  root.addEventListener("mousedown", (event) => {
    if (/** @type {Element} */ (event.target).closest("button") !== null) event.preventDefault();
  });
  // That one of a mouse's buttons is let go while another is down is told as a movement.
  root.addEventListener("pointermove", (event) => {
    if (event.pointerType === "mouse" && (event.buttons & 1) === 0) held.release(`pointer:${event.pointerId}`);
  });
  for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
    root.addEventListener(end, (event) => held.release(`pointer:${/** @type {PointerEvent} */ (event).pointerId}`));
  }
  root.addEventListener("contextmenu", (event) => event.preventDefault());
}

/**
 * Show on every key cap which key it is now.
 * @param {ParentNode} root
 * @param {import("./keymap.js").KeyMap} keymap
 */
export async function labelKeys(root, keymap) {
  const printed = await printedKeys();
  for (const cap of /** @type {NodeListOf<HTMLElement>} */ (root.querySelectorAll("kbd[data-binding]"))) {
    const code = keymap.codeOf(/** @type {string} */ (cap.dataset.binding));
    cap.hidden = code === undefined; // the robot's list of actions has none
    if (code === undefined) continue;
    setText(cap, printed(code) ?? keymap.capOf(code));
  }
}
