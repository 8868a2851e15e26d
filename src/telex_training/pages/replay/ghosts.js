// @ts-check
/** The runs that can be drawn beside a trial, as a choice. */

import { decimal, text } from "./language.js";

/** @typedef {{ghost: string, operator: string, seconds: number, same_places: boolean}} Run */

const EXPERT = "expert";
const STAMP = /^(\d{4}-\d\d-\d\d)_(\d\d)(\d\d)/;

/** @param {Run} run */
export function runText({ ghost, operator, seconds, same_places }) {
  const [, day, hour, minute] = STAMP.exec(ghost) ?? [];
  const who = ghost === EXPERT ? text("the expert") : `${operator || text("no name")}, ${day ? `${day} ${hour}:${minute}` : ghost}`;
  return `${who}: ${decimal(seconds, 1)} s${same_places ? "" : text(", things stood elsewhere")}`;
}

/**
 * By how much the ghost is before the trial, in words.
 * @param {string | null} ahead  As the picture says it (s); null: there is no ghost.
 */
export function aheadText(ahead) {
  if (ahead === null) return "";
  const by = Number(ahead);
  return Math.abs(by) < 0.05 ? text("ghost level") : by > 0 ? text("ghost {seconds} s ahead", { seconds: decimal(by, 1) }) : text("ghost {seconds} s behind", { seconds: decimal(-by, 1) });
}

/**
 * @param {HTMLSelectElement} choice @param {Run[]} runs
 */
export function offerRuns(choice, runs) {
  choice.append(...runs.map((run) => new Option(runText(run), run.ghost)));
  choice.disabled = runs.length === 0;
}
