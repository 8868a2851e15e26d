// @ts-check
/** The language of the console, at whose server these pages are; the server of a class has its files as well. */

// Where no page is, as in tests, it is found beside this package.
const ADDRESS = globalThis.document === undefined
  ? new URL("../../../telex_teleop/console/js/", import.meta.url)
  : new URL("/js/", location.origin);

/** @type {typeof import("../../../telex_teleop/console/js/language.js")} */
export const { decimal, onLanguage, term, text, translated } = await import(new URL("language.js", ADDRESS).href);

/** @type {typeof import("../../../telex_teleop/console/js/language/exercise.js")} */
export const { bringTexts, metricText } = await import(new URL("language/exercise.js", ADDRESS).href);

/** @type {typeof import("../../../telex_teleop/console/js/language/page.js")} */
export const { startLanguage } = await import(new URL("language/page.js", ADDRESS).href);
