// @ts-check
/** The texts of the pages in the language that is shown. */

/**
 * Translate what the page says.
 * @param {string} english  What is said in English, which is also its name in the tables of other languages; `{name}` stands for a value.
 * @param {Record<string, string | number>} [values]
 * @returns {string}
 */
export function text(english, values = {}) {
  return english.replace(/\{(\w+)\}/g, (whole, name) => (name in values ? String(values[name]) : whole));
}
