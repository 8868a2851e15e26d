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

/** An element of a page, as far as its modules make and fill them. */
export class FakeElement {
  /** @param {string} [tag] */
  constructor(tag = "") {
    Object.assign(this, { dataset: {}, hidden: false, textContent: "", value: "", checked: false, disabled: false, open: false });
    this.tag = tag;
    /** @type {any[]} */
    this.children = [];
    /** @type {FakeElement | null} */
    this._parent = null;
    /** @type {Record<string, (event: any) => void>} */
    this._listeners = {};
  }

  setAttribute() {}

  getAttribute() {
    return null;
  }

  querySelector() {
    return new FakeElement();
  }

  /** @param {any[]} children */
  append(...children) {
    this.children.push(...children);
    for (const child of children) if (child instanceof FakeElement) child._parent = this;
  }

  remove() {
    if (this._parent !== null) this._parent.children = this._parent.children.filter((child) => child !== this);
  }

  /** @param {any[]} children */
  replaceChildren(...children) {
    this.children = children;
  }

  /** @param {string} kind @param {(event: any) => void} hear */
  addEventListener(kind, hear) {
    this._listeners[kind] = hear;
  }

  /** @param {string} kind */
  fire(kind) {
    this._listeners[kind]({ preventDefault() {} });
  }

  showModal() {
    Object.assign(this, { open: true });
  }

  close() {
    Object.assign(this, { open: false });
  }

  /** Tags of all that is in it. @returns {string[]} */
  get tags() {
    return this.children.flatMap((child) => (typeof child === "string" ? [] : [child.tag, ...child.tags]));
  }
}
