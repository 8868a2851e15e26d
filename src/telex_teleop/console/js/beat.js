// @ts-check
/**
 * Lets what changes the page change it together: every time it costs the browser a style, a layout, a paint and a composite,
 * which without a graphics card are dear.
 */

const BEAT = 67; // ms

/** @type {Set<() => void>} */
const due = new Set();
/** Those of the present beat that were called already. @type {Set<() => void>} */
const done = new Set();

/**
 * Call back at the next beat, once however often it is asked for; what a callback asks for comes in its own beat still.
 * @param {() => void} callback
 */
export function atBeat(callback) {
  if (due.size === 0 && done.size === 0) setTimeout(beat, BEAT - (performance.now() % BEAT));
  due.add(callback);
}

function beat() {
  for (const callback of due) {
    if (done.has(callback)) continue;
    done.add(callback);
    due.delete(callback);
    try {
      callback();
    } catch (error) {
      reportError(error);
    }
  }
  done.clear();
  // What has asked for itself.
  if (due.size > 0) setTimeout(beat, BEAT);
}
