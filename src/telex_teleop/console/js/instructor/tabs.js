// @ts-check
/** Tabs of the instructor's panel: the lesson, and the scene with its plan. */

import { onClick } from "../buttons.js";

/**
 * @param {HTMLElement} list  Has a button for each, which names its part by aria-controls.
 * @param {(name: string) => void} changed  Told the part that is shown, at first as well.
 */
export function listenToTabs(list, changed) {
  const tabs = /** @type {HTMLElement[]} */ ([...list.querySelectorAll("[role=tab]")]);
  const partOf = (/** @type {HTMLElement} */ tab) => /** @type {HTMLElement} */ (document.getElementById(tab.getAttribute("aria-controls") ?? ""));
  const show = (/** @type {HTMLElement} */ shown) => {
    for (const tab of tabs) {
      const isShown = tab === shown;
      tab.setAttribute("aria-selected", String(isShown));
      tab.tabIndex = isShown ? 0 : -1;
      partOf(tab).hidden = !isShown;
    }
    changed(partOf(shown).id);
  };
  tabs.forEach((tab, index) => {
    onClick(tab, () => show(tab));
    tab.addEventListener("keydown", ({ key }) => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[key];
      if (step === undefined) return;
      const next = tabs[(index + step + tabs.length) % tabs.length];
      next.focus();
      show(next);
    });
  });
  show(tabs[0]);
}
