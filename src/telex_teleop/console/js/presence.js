// @ts-check
/** Hides the parts of the page for which the robot has no equipment. */

/** @typedef {import("./vocabulary.js").Action} Action */

/**
 * What some actions are about, as `data-needs` of the page's parts names it: kinds of actions, nodes whose joints are jogged, commands,
 * and `look`: what counts in CAMERA mode alone.
 * @param {Action[]} actions
 * @returns {Set<string>}
 */
export function subjectsOf(actions) {
  return new Set(actions.flatMap(({ does, modes }) => {
    const own = does.kind === "jog" ? [does.node] : does.kind === "command" ? [does.name] : [];
    return [does.kind, ...own, ...(modes.join() === "CAMERA" ? ["look"] : [])];
  }));
}

/**
 * Hide buttons of actions that the robot does not have, and the parts that are about nothing of it.
 * @param {Document} page
 * @param {import("./vocabulary.js").Vocabulary} vocabulary
 */
export function leaveOut(page, vocabulary) {
  for (const button of /** @type {NodeListOf<HTMLElement>} */ (page.querySelectorAll("[data-command]"))) {
    button.hidden = vocabulary.get(button.dataset.command ?? "") === undefined;
  }
  const subjects = subjectsOf(vocabulary.all);
  for (const part of /** @type {NodeListOf<HTMLElement>} */ (page.querySelectorAll("[data-needs]"))) {
    part.hidden = !subjects.has(part.dataset.needs ?? "");
  }
}

/**
 * Show buttons and keys of an action, or not.
 * @param {Document} page
 * @param {string} name
 * @param {boolean} isThere
 */
export function showAction(page, name, isThere) {
  const all = page.querySelectorAll(`[data-command="${name}"], [data-action="${name}"], [data-key="${name}"]`);
  for (const each of /** @type {NodeListOf<HTMLElement>} */ (all)) each.hidden = !isThere;
}

/**
 * How many cameras a command about the views needs. @type {Record<string, number>}
 */
const CAMERAS_FOR = { "next camera": 2, "swap views": 2, "second view": 2, "next second camera": 3, "small views": 3 };

/**
 * Which actions about the views have an effect.
 * @param {Action[]} actions
 * @param {number} cameras  How many there are.
 * @returns {Map<string, boolean>} By the action's name; others are not about views.
 */
export function viewActions(actions, cameras) {
  return new Map(actions.flatMap(({ name, does }) =>
    does.kind === "command" && does.name in CAMERAS_FOR ? [[name, cameras >= CAMERAS_FOR[does.name]]] : []));
}
