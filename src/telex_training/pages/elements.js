// @ts-check
/** Elements of the pages. */

/**
 * @param {string} kind
 * @param {string} [words]
 * @param {Record<string, string>} [attributes]
 * @param {Node[]} [children]
 */
export function element(kind, words = "", attributes = {}, children = []) {
  const made = document.createElement(kind);
  if (words !== "") made.textContent = words;
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}
