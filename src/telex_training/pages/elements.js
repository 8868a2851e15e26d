// @ts-check
/** Elements of the pages. */

/**
 * @param {string} kind
 * @param {string} [text]
 * @param {Record<string, string>} [attributes]
 * @param {Node[]} [children]
 */
export function element(kind, text = "", attributes = {}, children = []) {
  const made = document.createElement(kind);
  if (text !== "") made.textContent = text;
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}
