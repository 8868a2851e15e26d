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

/**
 * @param {string} words
 * @param {() => void} [act]  What a click does; left out where somebody else listens.
 * @param {string} [className]
 */
export function makeButton(words, act, className = "small") {
  const button = document.createElement("button");
  Object.assign(button, { type: "button", className, textContent: words });
  if (act !== undefined) onClick(button, act);
  return button;
}
