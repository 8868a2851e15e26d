// @ts-check
/** What each aid draws into a picture, as figures that tell by shape and words what they tell by colour. */

import { decimal, text } from "../language.js";
import { fixed } from "../panels.js";
import { guideLines, horizon, plus } from "./lines.js";

/** @typedef {import("../urdf.js").Vector} Vector */
/** @typedef {import("./sight.js").Sight} Sight */
/** @typedef {import("./sight.js").Place} Place */

/**
 * @typedef {{kind: "lines", lines: Place[][], colour: string, width: number, dash?: number[]}} Lines
 * @typedef {{kind: "sign", shape: "ring" | "disc" | "rhomb" | "triangle", at: Place, colour: string, size: number}} Sign
 * @typedef {{kind: "label", at: Place, words: string, align: "left" | "right"}} Label  Of a line; `at`: the middle of that end.
 * @typedef {Lines | Sign | Label} Figure
 * @typedef {{words: string, isAid: boolean}} Plate  What stands over the picture's upper third; whether a training aid says it.
 * @typedef {{figures: Figure[], plates: Plate[]}} Shown
 */

/** @type {Shown} */
const NOTHING = { figures: [], plates: [] };

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
      ...(end === null ? [] : [label([end[0] + 6, end[1]], text("{length} m", { length: decimal(distance, 2, 0) }), "left")]),
    ];
  }));
}

/** @param {Place} at @param {string} words @param {Label["align"]} align @returns {Label} */
const label = (at, words, align) => ({ kind: "label", at, words, align });

/**
 * @param {Sight} sight
 * @param {Aim} aim
 * @param {number | null} range  Measured (m); null: there is no figure.
 * @param {string} beyond         What is said then; empty: nothing measures.
 * @param {boolean} isAid        Whether what measures is a training aid.
 * @returns {Shown}
 */
export function aimFigures(sight, { origin, ahead }, range, beyond, isAid) {
  const length = range ?? REACH;
  const end = plus(origin, ahead, length);
  const lines = sight.line([origin, end]);
  if (!sight.sees(lines)) return NOTHING;
  /** @type {Figure[]} */
  const figures = [{ kind: "lines", lines, colour: AIM, width: 2 }];
  for (let along = TICK; along < length - TICK / 2; along += TICK) {
    const at = sight.place(plus(origin, ahead, along));
    if (at !== null) figures.push({ kind: "sign", shape: "disc", at, colour: AIM, size: 3 });
  }
  const at = sight.place(end);
  const [shape, size] = range === null ? /** @type {const} */ (["triangle", 6]) : /** @type {const} */ (["ring", 9]);
  if (at !== null) figures.push({ kind: "sign", shape, at, colour: AIM, size });
  const says = range === null ? beyond : inMetres(range);
  return { figures, plates: says === "" ? [] : [{ words: text("range {range}", { range: says }), isAid }] };
}

/**
 * The gap of the fingers where the object is.
 * @param {Sight} sight
 * @param {Aim} aim
 * @param {number} opening         Between the pads (m).
 * @param {number | null} distance  To the object, from the middle between the pads (m).
 * @param {number | null} width     Of the object, from pad to pad (m); null: not known.
 * @param {boolean} isAid            Whether what measures the distance is a training aid.
 * @returns {Shown}
 */
export function gapFigures(sight, { ahead, across, middle }, opening, distance, width, isAid) {
  if (across === null || middle === null) return NOTHING;
  const there = plus(middle, ahead, distance ?? CORRIDOR);
  const up = /** @type {Vector} */ ([
    ahead[1] * across[2] - ahead[2] * across[1], ahead[2] * across[0] - ahead[0] * across[2], ahead[0] * across[1] - ahead[1] * across[0],
  ]);
  const sides = [0.5, -0.5].map((share) => ({ from: plus(middle, across, share * opening), to: plus(there, across, share * opening) }));
  const rails = sides.flatMap(({ from, to }) => sight.line([from, to]));
  const brackets = sides.flatMap(({ to }) => sight.line([plus(to, up, BRACKET), plus(to, up, -BRACKET)]));
  const between = sight.line(sides.map(({ to }) => to));
  if (!sight.sees([...rails, ...brackets, ...between])) return NOTHING;
  const fits = width === null ? null : width + LEAST_SPARE <= opening;
  const colour = fits === null ? GAP : fits ? TOUCH : SLIP;
  const gap = text("gap {gap} mm", { gap: Math.round(1000 * opening) });
  return {
    figures: [
      { kind: "lines", lines: [...rails, ...between], colour, width: 1.5, dash: [3, 5] },
      { kind: "lines", lines: brackets, colour, width: 4 },
    ],
    plates: [
      { words: gap, isAid: isAid && distance !== null },
      ...(fits === null ? [] : [{ words: fits ? text("✔ fits") : text("✖ does not fit"), isAid: true }]),
    ],
  };
}

/**
 * @param {Sight} sight
 * @param {Pressed[]} pads
 * @param {boolean} isAid  Whether the robot has no such pads.
 * @returns {Shown}
 */
export function contactFigures(sight, pads, isAid) {
  const marks = pads.flatMap(({ at, force, slips, speed, weak }) => {
    const place = sight.place(at);
    if (place === null) return [];
    const newtons = Math.round(force);
    const [shape, colour, words] = slips ? /** @type {const} */ (["rhomb", SLIP, text("◆ SLIPS {speed} mm/s", { speed: Math.round(1000 * speed) })])
      : weak ? /** @type {const} */ (["triangle", WEAK, text("▲ weak {force} N", { force: newtons })])
        : /** @type {const} */ (["disc", TOUCH, text("● {force} N", { force: newtons })]);
    return [{ figure: { kind: /** @type {const} */ ("sign"), shape, at: place, colour, size: slips ? 10 : 8 }, words }];
  });
  const said = [...new Set(marks.map(({ words }) => words))];
  return { figures: marks.map(({ figure }) => figure), plates: said.map((words) => ({ words, isAid })) };
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
