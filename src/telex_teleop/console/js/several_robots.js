// @ts-check
/** Several robots in one scene: which one a page shows, and where the simulator's own services are. */

/** @typedef {import("./config.js").Config} Config */

/** Services and topics of the simulator that all robots share; whatever else stands in `sim/` is each robot's own. */
const SIMULATOR = new Set([
  "sim/pause", "sim/unpause", "sim/step", "sim/reset", "sim/bookmark", "sim/restore", "sim/list_bookmarks", "sim/list_scenes",
  "sim/load_scene", "sim/spawn", "sim/delete", "sim/list_objects", "sim/find_place", "sim/move", "sim/set_light", "sim/poses",
]);

/** @param {Config} config @returns {string} */
export const robotOf = (config) => config.namespace.replace(/^\//, "");

/**
 * Gives names inside the shown robot's namespace their global form.
 * @param {Config} config
 * @returns {(name: string) => string}
 */
export const globalNames = (config) => (name) =>
  `${SIMULATOR.has(name) ? config.simulator ?? config.namespace : config.namespace}/${name}`;

/**
 * Say on the page which robot it shows; where there are several, larger.
 * @param {Config} config
 * @param {HTMLElement} brand
 */
export function showRobot(config, brand) {
  const name = robotOf(config);
  if (config.robots === undefined) {
    // In capitals, as the page has the name of the default robot.
    if (brand.textContent === name.toUpperCase()) return;
    brand.textContent = name.toUpperCase();
  } else {
    brand.textContent = name;
    brand.dataset.several = "true";
  }
  document.title = `${name} · ${document.title}`;
}
