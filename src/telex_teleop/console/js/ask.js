// @ts-check
/** Asks once before something that others would feel. */

import { byId, setText } from "./panels.js";

/**
 * @param {string} sentence
 * @param {string} deed  What the button says that does it.
 * @returns {Promise<boolean>}
 */
export function ask(sentence, deed) {
  const dialog = /** @type {HTMLDialogElement} */ (byId("ask"));
  // A second question takes the place of one that nobody has answered.
  if (dialog.open) dialog.close();
  setText(byId("ask-sentence"), sentence);
  setText(byId("ask-yes"), deed);
  return new Promise((resolve) => {
    let isWanted = false;
    byId("ask-yes").onclick = () => {
      isWanted = true;
      dialog.close();
    };
    byId("ask-no").onclick = () => dialog.close();
    dialog.onclose = () => resolve(isWanted);
    dialog.showModal();
    byId("ask-no").focus();
  });
}
