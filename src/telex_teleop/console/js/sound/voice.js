// @ts-check
/** Says alarms by a voice that this machine has itself: what is said never goes to another machine. */

/** @typedef {{lang: string, localService: boolean}} Voice  Of the browser. */

/**
 * A voice of this machine in a language; null: there is none.
 * @template {Voice} Any
 * @param {Any[]} voices
 * @param {string} language  As the page's, "en" or "de-CH".
 */
export function localVoice(voices, language) {
  const base = (/** @type {string} */ tag) => tag.toLowerCase().split(/[-_]/)[0];
  const local = voices.filter((voice) => voice.localService === true && base(voice.lang) === base(language));
  return local.find((voice) => voice.lang.toLowerCase().replace("_", "-") === language.toLowerCase()) ?? local[0] ?? null;
}

/**
 * Say words in the page's language, in place of what is said.
 * @param {string} words
 * @param {number} volume  0 to 1
 * @returns {boolean} Whether there is a voice that says them.
 */
export function say(words, volume) {
  const { speechSynthesis: speech } = globalThis;
  if (speech === undefined) return false;
  const voice = localVoice(speech.getVoices(), document.documentElement.lang);
  if (voice === null) return false;
  const said = new SpeechSynthesisUtterance(words);
  Object.assign(said, { voice, lang: voice.lang, volume });
  speech.cancel();
  speech.speak(said);
  return true;
}

/** Say nothing more. */
export function hush() {
  globalThis.speechSynthesis?.cancel();
}
