// @ts-check
/** What stands in a band over the upper third of a picture: compass, zoom, and whether training aids are shown. */

import { text } from "../language.js";
import { fixed } from "../panels.js";

/** @typedef {import("./figures.js").Plate} Plate */
/** @typedef {import("./sight.js").Box} Box */

/** @typedef {{kind: "ribbon", left: number, top: number, width: number, height: number, ticks: {x: number, words: string}[], nose: number | null}} Ribbon
 *  Ticks (px from its left), and where the robot's nose points; null: beside the ribbon. */

/** @typedef {{kind: "plates", left: number, right: number, top: number, bottom: number, plates: Plate[]}} Plates
 *  Beside and below each other, as many as there is room for. */

const RIBBON = 30; // px, its height
const SHARE = 1 / 3; // of the picture, that may have something over it
const WIDEST = 340; // px, of the ribbon
const SPAN = 120; // degrees that the ribbon shows
const EVERY = 15; // degrees between its ticks, of which every other one has its number

/** @param {number} angle  Degrees. @returns {number} Within half a turn to both sides. */
const wrapped = (angle) => ((((angle + 180) % 360) + 360) % 360) - 180;

/** @param {number} degrees */
const bearing = (degrees) => `${String(((Math.round(degrees) % 360) + 360) % 360).padStart(3, "0")}°`;

/**
 * A ribbon about a heading.
 * @param {number} heading  In its middle (degrees, clockwise).
 * @param {number} nose     Heading of the robot.
 * @param {{left: number, top: number, width: number}} room
 * @returns {Ribbon}
 */
export function ribbonOf(heading, nose, { left, top, width }) {
  const wide = Math.min(WIDEST, width - 8);
  const perDegree = wide / SPAN;
  const ticks = [];
  for (let degrees = Math.ceil((heading - SPAN / 2) / EVERY) * EVERY; degrees <= heading + SPAN / 2; degrees += EVERY) {
    ticks.push({ x: Math.round(wide / 2 + (degrees - heading) * perDegree), words: degrees % (2 * EVERY) === 0 ? bearing(degrees).slice(0, 3) : "" });
  }
  const off = wrapped(nose - heading);
  const at = Math.abs(off) <= SPAN / 2 ? Math.round(wide / 2 + off * perDegree) : null;
  return { kind: "ribbon", left: Math.round(left + (width - wide) / 2), top, width: wide, height: RIBBON, ticks, nose: at };
}

/**
 * @param {Box} box     Of the picture.
 * @param {number} top  Below what stands over the picture anyway (px).
 * @param {{heading: number, nose: number} | null} compass  Degrees, clockwise.
 * @param {Plate[]} plates
 * @param {number} free  At its right, where there is a button (px).
 * @returns {(Ribbon | Plates)[]}  No more than there is room for.
 */
export function bandFigures(box, top, compass, plates, free) {
  /** @type {(Ribbon | Plates)[]} */
  const figures = [];
  let below = Math.max(top, box.top) + 2;
  const end = box.top + SHARE * box.height;
  if (compass !== null && below + RIBBON <= end) {
    figures.push(ribbonOf(compass.heading, compass.nose, { left: box.left, top: below, width: box.width }));
    below += RIBBON + 2;
  }
  const legend = plates.some(({ isAid }) => isAid) ? [{ words: text("training aid"), isAid: true }] : [];
  const all = [...plates, ...legend];
  if (all.length > 0) figures.push({ kind: "plates", left: box.left + 4, right: box.left + box.width - 4 - free, top: below, bottom: end, plates: all });
  return figures;
}

/**
 * @param {number | null} zoom  Factor; null: not known.
 * @param {number} field        Angle across the picture (rad).
 */
export function zoomText(zoom, field) {
  const angle = text("{angle}° wide", { angle: Math.round((field * 180) / Math.PI) });
  return zoom === null ? angle : text("zoom {factor}×, {angle}", { factor: fixed(zoom, 1), angle });
}
