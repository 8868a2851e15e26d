// @ts-check
/** What each aid draws into a picture, as figures that tell by shape and words what they tell by colour. */

import { text } from "../language.js";
import { fixed } from "../panels.js";
import { guideLines, horizon, plus } from "./lines.js";

/** @typedef {import("../urdf.js").Vector} Vector */
/** @typedef {import("./sight.js").Sight} Sight */
/** @typedef {import("./sight.js").Place} Place */

/**
 * @typedef {{kind: "lines", lines: Place[][], colour: string, width: number, dash?: number[]}} Lines
 * @typedef {{kind: "sign", shape: "ring" | "disc" | "rhomb" | "triangle", at: Place, colour: string, size: number}} Sign
 * @typedef {{kind: "label", at: Place, words: string, align: "left" | "center" | "right", framed?: boolean}} Label
 *   `at`: the middle of its left or right end, or its middle; `framed`: what it says is a training aid's.
 * @typedef {Lines | Sign | Label} Figure
 */

/** @typedef {{origin: Vector, ahead: Vector, across: Vector | null, middle: Vector | null}} Aim
 *  Where the aim line begins and leads; from pad to pad of the fingers, and the middle between them. */
/** @typedef {{at: Vector, force: number, slips: boolean, speed: number, weak: boolean}} Pressed  A pad that presses on something. */

/** By the guide line's distance (m): how it differs from the others. @type {Record<number, {colour: string, width: number, dash?: number[]}>} */
const GUIDES = { 0.5: { colour: "#ff9d94", width: 4 }, 1: { colour: "#ffd35c", width: 3 }, 2: { colour: "#8fe39b", width: 2, dash: [9, 6] } };

const AIM = "#5cc8ff", GAP = "#ffffff", HORIZON = "#d7b8ff", TOUCH = "#8fe39b", WEAK = "#ffd35c", SLIP = "#ff9d94";
const REACH = 1; // m that the aim line is long where no range is known
const TICK = 0.25; // m between its ticks
const CORRIDOR = 0.3; // m ahead of the fingers at which their gap is drawn where no range is known
const BRACKET = 0.02; // m, half the height of the gap's ends
const LEAST_SPARE = 0.004; // m that the gap has to be wider than what fits

/** @param {number} metres */
const inMetres = (metres) => text("{length} m", { length: fixed(metres, 2) });

/**
 * @param {Sight} sight
 * @param {import("./lines.js").Gear} gear
 * @param {import("./lines.js").Floor} floor
 * @returns {Figure[]}
 */
export function guideFigures(sight, gear, floor) {
  return [1, -1].flatMap((way) => guideLines(gear, floor, /** @type {1 | -1} */ (way)).flatMap(({ distance, rung, sides }) => {
    const style = GUIDES[distance];
    const lines = [...sides, rung].flatMap((points) => sight.line(points));
    if (!sight.sees(lines)) return [];
    const end = sight.place(rung[way > 0 ? 1 : 0]) ?? sight.place(plus(rung[0], plus(rung[1], rung[0], -1), 0.5));
    return [
      { kind: /** @type {const} */ ("lines"), lines, ...style },
      ...(end === null ? [] : [label([end[0] + 6, end[1]], text("{length} m", { length: distance }), "left")]),
    ];
  }));
}

/**
 * @param {Place} at
 * @param {string} words
 * @param {Label["align"]} align
 * @param {boolean} [framed]
 * @returns {Label}
 */
const label = (at, words, align, framed = false) => ({ kind: "label", at, words, align, ...(framed ? { framed } : {}) });

/**
 * @param {Sight} sight
 * @param {Aim} aim
 * @param {number | null} range  Measured (m); null: there is no figure.
 * @param {string} beyond         What is said then; empty: nothing measures.
 * @param {boolean} isAid        Whether what measures is a training aid.
 * @returns {Figure[]}
 */
export function aimFigures(sight, { origin, ahead }, range, beyond, isAid) {
  const length = range ?? REACH;
  const end = plus(origin, ahead, length);
  const lines = sight.line([origin, end]);
  if (!sight.sees(lines)) return [];
  /** @type {Figure[]} */
  const figures = [{ kind: "lines", lines, colour: AIM, width: 2 }];
  for (let along = TICK; along < length - TICK / 2; along += TICK) {
    const at = sight.place(plus(origin, ahead, along));
    if (at !== null) figures.push({ kind: "sign", shape: "disc", at, colour: AIM, size: 3 });
  }
  const at = sight.place(end);
  if (at === null) return figures;
  const side = /** @type {Place} */ ([at[0] + 14, at[1]]);
  if (range === null) figures.push({ kind: "sign", shape: "triangle", at, colour: AIM, size: 6 }, label(side, beyond || text("{length} m ahead", { length }), "left", isAid && beyond !== ""));
  else figures.push({ kind: "sign", shape: "ring", at, colour: AIM, size: 9 }, label(side, inMetres(range), "left", isAid));
  return figures;
}

/**
 * The gap of the fingers where the object is.
 * @param {Sight} sight
 * @param {Aim} aim
 * @param {number} opening         Between the pads (m).
 * @param {number | null} distance  To the object, from the middle between the pads (m).
 * @param {number | null} width     Of the object, from pad to pad (m); null: not known.
 * @param {boolean} isAid            Whether what measures it is a training aid.
 * @returns {Figure[]}
 */
export function gapFigures(sight, { ahead, across, middle }, opening, distance, width, isAid) {
  if (across === null || middle === null) return [];
  const there = plus(middle, ahead, distance ?? CORRIDOR);
  const up = /** @type {Vector} */ ([
    ahead[1] * across[2] - ahead[2] * across[1], ahead[2] * across[0] - ahead[0] * across[2], ahead[0] * across[1] - ahead[1] * across[0],
  ]);
  const sides = [0.5, -0.5].map((share) => ({ from: plus(middle, across, share * opening), to: plus(there, across, share * opening) }));
  const rails = sides.flatMap(({ from, to }) => sight.line([from, to]));
  const brackets = sides.flatMap(({ to }) => sight.line([plus(to, up, BRACKET), plus(to, up, -BRACKET)]));
  const between = sight.line(sides.map(({ to }) => to));
  if (!sight.sees([...rails, ...brackets, ...between])) return [];
  const fits = width === null ? "" : width + LEAST_SPARE <= opening ? text("✔ fits") : text("✖ does not fit");
  const words = [text("gap {gap} mm", { gap: Math.round(1000 * opening) }), fits].filter(Boolean).join(" ");
  // Below the bracket, where there is no label of the aim line.
  const at = sight.place(plus(there, up, -2 * BRACKET)) ?? sight.place(there);
  const colour = fits === "" ? GAP : width !== null && width + LEAST_SPARE <= opening ? TOUCH : SLIP;
  return [
    { kind: "lines", lines: rails, colour, width: 1.5, dash: [3, 5] },
    { kind: "lines", lines: between, colour, width: 1.5, dash: [3, 5] },
    { kind: "lines", lines: brackets, colour, width: 4 },
    ...(at === null ? [] : [label([at[0], at[1] + 14], words, "center", isAid && (distance !== null || fits !== ""))]),
  ];
}

/**
 * @param {Sight} sight
 * @param {Pressed[]} pads
 * @param {boolean} isAid  Whether the robot has no such pads.
 * @returns {Figure[]}
 */
export function contactFigures(sight, pads, isAid) {
  return pads.flatMap(({ at, force, slips, speed, weak }) => {
    const place = sight.place(at);
    if (place === null) return [];
    const shape = slips ? "rhomb" : weak ? "triangle" : "disc";
    const colour = slips ? SLIP : weak ? WEAK : TOUCH;
    const newtons = Math.round(force);
    const words = slips ? text("SLIPS {speed} mm/s", { speed: Math.round(1000 * speed) }) : weak ? text("weak {force} N", { force: newtons }) : text("{force} N", { force: newtons });
    return [
      { kind: /** @type {const} */ ("sign"), shape: /** @type {Sign["shape"]} */ (shape), at: place, colour, size: slips ? 10 : 8 },
      label([place[0], place[1] + 22], words, "center", isAid),
    ];
  });
}

/** @param {Sight} sight @param {Vector} up @returns {Figure[]} */
export function horizonFigures(sight, up) {
  const lines = sight.farLine(horizon(sight.pose, up));
  if (!sight.sees(lines)) return [];
  const { left, width } = sight.box;
  const shown = lines.flat().filter(([x]) => x >= left && x <= left + width);
  const last = shown.at(-1);
  return [
    { kind: "lines", lines, colour: HORIZON, width: 2, dash: [14, 6, 3, 6] },
    ...(last === undefined ? [] : [label([left + width - 4, last[1]], text("horizon"), "right")]),
  ];
}
