// @ts-check
/** The form with which somebody writes a note at the moment that is shown. */

import { text, translated } from "./language.js";

/**
 * @param {HTMLFormElement} form  With a text, a button and a status.
 * @param {() => number} time  Of the moment that is shown (s).
 * @param {(note: {at: number, text: string}) => Promise<void>} send
 */
export function listenToNotes(form, time, send) {
  const field = /** @type {HTMLInputElement} */ (form.querySelector("input"));
  const button = /** @type {HTMLButtonElement} */ (form.querySelector("button"));
  const status = /** @type {HTMLElement} */ (form.querySelector("[role=status]"));
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    if (!field.value.trim()) return;
    button.disabled = true;
    status.textContent = text("writing …");
    try {
      await send({ at: Number(time().toFixed(3)), text: field.value });
      field.value = "";
      status.textContent = "";
    } catch (error) {
      status.textContent = text("not written: {why}", { why: translated(/** @type {Error} */ (error).message) });
    }
    button.disabled = false;
  });
}
