// @ts-check
/** What the browser keeps for the next visit. What it does not keep, this page has until it is closed. */

/** @typedef {Pick<Storage, "getItem" | "setItem">} Keeper */

/** What the browser did not keep. @type {Map<string, string>} */
const unkept = new Map();

/** Where site data is blocked, a look at `localStorage` fails; where it is full, a change does. @type {Keeper} */
export const storage = {
  getItem(name) {
    try {
      return unkept.get(name) ?? localStorage.getItem(name);
    } catch {
      return null;
    }
  },

  setItem(name, value) {
    try {
      localStorage.setItem(name, value);
      unkept.delete(name);
    } catch {
      unkept.set(name, value);
    }
  },
};
