// @ts-check
/** The runs that can be drawn beside a trial, as a choice. */

/** @typedef {{ghost: string, operator: string, seconds: number, same_places: boolean}} Run */

const EXPERT = "expert";
const STAMP = /^(\d{4}-\d\d-\d\d)_(\d\d)(\d\d)/;

/** @param {Run} run */
export function runText({ ghost, operator, seconds, same_places }) {
  const [, day, hour, minute] = STAMP.exec(ghost) ?? [];
  const who = ghost === EXPERT ? "the expert" : `${operator || "no name"}, ${day ? `${day} ${hour}:${minute}` : ghost}`;
  return `${who}: ${seconds.toFixed(1)} s${same_places ? "" : ", things stood elsewhere"}`;
}

/**
 * By how much the ghost is before the trial, in words.
 * @param {string | null} ahead  As the picture says it (s); null: there is no ghost.
 */
export function aheadText(ahead) {
  if (ahead === null) return "";
  const by = Number(ahead);
  return Math.abs(by) < 0.05 ? "ghost level" : `ghost ${Math.abs(by).toFixed(1)} s ${by > 0 ? "ahead" : "behind"}`;
}

/**
 * @param {HTMLSelectElement} choice @param {Run[]} runs
 */
export function offerRuns(choice, runs) {
  choice.append(...runs.map((run) => new Option(runText(run), run.ghost)));
  choice.disabled = runs.length === 0;
}
