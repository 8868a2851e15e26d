// @ts-check
/** Notices that the operator may no longer be in control of the page. */

/** A tick (ms) that comes later than this says that the page hung or slept. */
const MAX_GAP = 200;

/**
 * Watch for everything after which held keys must not count any more.
 * @param {(reason: string) => void} letGo
 */
export function watchOperator(letGo) {
  window.addEventListener("blur", () => letGo("the window lost the focus"));
  window.addEventListener("pagehide", () => letGo("the page was left"));
  document.addEventListener("freeze", () => letGo("the page was frozen"));
  document.addEventListener("visibilitychange", () => {
    if (document.hidden) letGo("the page was hidden");
  });
}

/**
 * Call back at a steady pace, and tell when the pace was not kept.
 * @param {number} period  ms
 * @param {() => void} tick
 * @param {(reason: string) => void} letGo
 */
export function keepPace(period, tick, letGo) {
  let last = performance.now();
  setInterval(() => {
    const now = performance.now();
    if (now - last > MAX_GAP) letGo(`the page stood still for ${((now - last) / 1000).toFixed(1)} s`);
    last = now;
    tick();
  }, period);
}
