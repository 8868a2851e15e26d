/** What the console's modules need of a browser, under the tests' control. Imported before them. */

/** Time (ms) that performance.now() tells. */
export const clock = { now: 1000 };
Object.defineProperty(globalThis, "performance", { value: { now: () => clock.now, timeOrigin: 0 } });

/** What was asked to be called at a pace. @type {Array<() => void>} */
export const paced = [];
globalThis.setInterval = /** @type {any} */ ((/** @type {() => void} */ tick) => paced.push(tick));

// Node's own would keep the process alive.
globalThis.BroadcastChannel = /** @type {any} */ (class {
  postMessage() {}
});

/** A browser's localStorage. */
export class FakeStorage {
  /** @param {Record<string, string>} [values] */
  constructor(values = {}) {
    this.values = values;
  }

  /** @param {string} name */
  getItem(name) {
    return this.values[name] ?? null;
  }

  /** @param {string} name @param {string} value */
  setItem(name, value) {
    this.values[name] = value;
  }
}
