// @ts-check
/** A page's own markup in the language that is shown, and the button that changes the language. */

import { onClick } from "../buttons.js";
import { again, keep, language, nextLanguage, onLanguage, text } from "../language.js";

const ATTRIBUTES = ["title", "aria-label", "placeholder", "alt", "label"];

/** What is not translated: keys that are labelled by the keyboard, and sentences that somebody else has said. */
const AS_IT_IS = "script, style, kbd[data-binding], textarea, #log";

/** Say all anew that stands on the page, in text and attributes. @param {(sentence: string) => string} say */
function translate(say) {
  document.documentElement.lang = language().code;
  const walker = document.createTreeWalker(document, NodeFilter.SHOW_TEXT);
  for (let node = walker.nextNode(); node !== null; node = walker.nextNode()) {
    const { data } = /** @type {Text} */ (node);
    const [, before, sentence, after] = /** @type {RegExpExecArray} */ (/^(\s*)([^]*?)(\s*)$/.exec(data));
    if (sentence === "" || node.parentElement?.closest(AS_IT_IS)) continue;
    const words = sentence.replace(/\s+/g, " ");
    const now = say(words);
    if (now !== words) /** @type {Text} */ (node).data = before + now + after;
  }
  for (const name of ATTRIBUTES) {
    for (const element of document.querySelectorAll(`[${name}]`)) {
      const sentence = element.getAttribute(name) ?? "";
      const now = say(sentence);
      if (now !== sentence) element.setAttribute(name, now);
    }
  }
}

/**
 * Begin with the language that is asked for; a button of the page with the id `language`, where there is one, leads to the next.
 * @param {(sentence: string) => string} [say]  Translates what stands on the page.
 */
export function startLanguage(say = again) {
  const button = document.getElementById("language");
  const show = () => {
    translate(say);
    if (button === null) return;
    button.textContent = language().code.toUpperCase();
    button.title = text("Language: {name}. Press for the next one.", { name: language().name });
  };
  // Asked for by the address, it holds for the pages that this one leads to.
  if (new URLSearchParams(location.search).has("lang")) keep();
  onLanguage(() => {
    // What the address asks for must not come back with the next load.
    const address = new URL(location.href);
    address.searchParams.delete("lang");
    history.replaceState(history.state, "", address);
    show();
  });
  if (button !== null) onClick(button, nextLanguage);
  show();
}
