// @ts-check
/** From keys and pointers to held actions. */

import { COMMAND_OF_KEY } from "./robot.js";

/**
 * Let keys hold actions, by their position on the keyboard.
 * @param {import("./held.js").Held} held
 * @param {() => boolean} mayPress  Whether actions can be held now.
 * @param {(code: string) => string | undefined} actionOfKey  Name of the action that a key has now.
 * @param {Record<import("./robot.js").Command, () => void>} commands
 */
export function listenToKeys(held, mayPress, actionOfKey, commands) {
  window.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.isComposing) return;
    const action = actionOfKey(event.code);
    const command = COMMAND_OF_KEY.get(event.code);
    if (action === undefined && command === undefined) return;
    event.preventDefault();
    // A key that repeats was pressed before, perhaps before everything was released: that is no new press.
    if (event.repeat) return;
    if (command !== undefined) commands[command]();
    else if (action !== undefined && mayPress()) held.press(`key:${event.code}`, action);
  }, { capture: true });
  window.addEventListener("keyup", (event) => {
    // Space on a focused button would click it.
    if (COMMAND_OF_KEY.has(event.code)) event.preventDefault();
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
    if (!mayPress()) return;
    button.setPointerCapture(event.pointerId);
    held.press(`pointer:${event.pointerId}`, /** @type {string} */ (button.dataset.action));
  });
  for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
    root.addEventListener(end, (event) => held.release(`pointer:${/** @type {PointerEvent} */ (event).pointerId}`));
  }
  root.addEventListener("contextmenu", (event) => event.preventDefault());
}

/**
 * Show on every key cap what the user's own keyboard has at that position, where the browser knows it.
 * @param {ParentNode} root
 */
export async function labelKeys(root) {
  const keyboard = /** @type {any} */ (navigator).keyboard;
  if (!keyboard?.getLayoutMap) return;
  const layout = await keyboard.getLayoutMap();
  for (const cap of root.querySelectorAll("kbd[data-code]")) {
    const label = layout.get(/** @type {HTMLElement} */ (cap).dataset.code);
    if (label) cap.textContent = label.toUpperCase();
  }
}
