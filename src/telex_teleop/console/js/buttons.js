// @ts-check
/** Buttons that leave the focus where it is: Space must never click one that was clicked before. */

/**
 * @param {HTMLElement} button
 * @param {() => void} act
 */
export function onClick(button, act) {
  button.addEventListener("pointerdown", (event) => event.preventDefault());
  button.addEventListener("mousedown", (event) => event.preventDefault());
  button.addEventListener("click", act);
}
