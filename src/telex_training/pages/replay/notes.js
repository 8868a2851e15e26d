// @ts-check
/** The form with which somebody writes a note at the moment that is shown. */

/**
 * @param {HTMLFormElement} form  With a text, a button and a status.
 * @param {() => number} time  Of the moment that is shown (s).
 * @param {(note: {at: number, text: string}) => Promise<void>} send
 */
export function listenToNotes(form, time, send) {
  const text = /** @type {HTMLInputElement} */ (form.querySelector("input"));
  const button = /** @type {HTMLButtonElement} */ (form.querySelector("button"));
  const status = /** @type {HTMLElement} */ (form.querySelector("[role=status]"));
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    if (!text.value.trim()) return;
    button.disabled = true;
    status.textContent = "writing …";
    try {
      await send({ at: Number(time().toFixed(3)), text: text.value });
      text.value = "";
      status.textContent = "";
    } catch (error) {
      status.textContent = `not written: ${/** @type {Error} */ (error).message}`;
    }
    button.disabled = false;
  });
}
