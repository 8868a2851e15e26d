// @ts-check
/** Asks once before something that others would feel. */

import { byId, setText } from "./panels.js";

/** Answers the question that is open, if one is. @type {(isWanted: boolean) => void} */
let answer = () => {};

/**
 * Nothing else on the page waits for the answer: E-STOP, above all, can be pressed meanwhile.
 * @param {string} sentence
 * @param {string} deed  What the button says that does it.
 * @returns {Promise<boolean>}
 */
export function ask(sentence, deed) {
  const dialog = /** @type {HTMLDialogElement} */ (byId("ask"));
  // A second question takes the place of one that nobody has answered.
  answer(false);
  setText(byId("ask-sentence"), sentence);
  setText(byId("ask-yes"), deed);
  return new Promise((resolve) => {
    answer = (isWanted) => {
      dialog.close();
      resolve(isWanted);
    };
    byId("ask-yes").onclick = () => answer(true);
    byId("ask-no").onclick = () => answer(false);
    dialog.show();
    byId("ask-no").focus();
  });
}

// Besides being the e-stop.
window.addEventListener("keydown", ({ key }) => {
  if (key === "Escape") answer(false);
});
