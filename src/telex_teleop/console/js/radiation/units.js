// @ts-check
/** Doses and dose rates as texts. */

import { decimal } from "../language.js";

/** From the greatest; what is less than the last is told in it. */
const PREFIXES = /** @type {const} */ ([["k", 1e3], ["", 1], ["m", 1e-3], ["µ", 1e-6]]);

const DIGITS = 3;

/**
 * A figure with three digits and the prefix that suits it.
 * @param {number | null} value  null is what the bridge makes of a figure that is none.
 * @param {string} unit
 */
export function withPrefix(value, unit) {
  if (value === null || !Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  // Rounding must not lead to 1000 of a smaller unit.
  const [prefix, scale] = PREFIXES.find(([, each]) => size >= 0.9995 * each) ?? PREFIXES[PREFIXES.length - 1];
  const scaled = value / scale;
  const whole = Math.max(1, Math.floor(Math.log10(Math.max(Math.abs(scaled), 1)) + 1e-4) + 1);
  const digits = Math.max(0, DIGITS - whole);
  return `${Number(scaled.toFixed(digits)) === 0 ? "0" : decimal(scaled, digits)} ${prefix}${unit}`;
}

/** @param {number | null} rate  Gy/h */
export const rateText = (rate) => withPrefix(rate, "Gy/h");

/** @param {number | null} dose  Gy */
export const doseText = (dose) => withPrefix(dose, "Gy");
