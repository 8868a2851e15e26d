// @ts-check
/** What of the robot may be heard and felt: what it is equipped with, and in practice training aids beside. */

/** @typedef {"equipment" | "aid" | "none"} Right */
/** @typedef {{motors: Right, tracks: Right, touch: Right}} Rights  Motors; tracks on the ground; what the gripper touches. */

/**
 * @param {Record<string, unknown>} equipment  As the robot's variant declares it.
 * @param {boolean} isExam
 * @returns {Rights}
 */
export function rights(equipment, isExam) {
  const aid = isExam ? "none" : "aid";
  const has = (/** @type {string} */ name) => equipment[name] !== undefined && equipment[name] !== null;
  if (has("microphone")) return { motors: "equipment", tracks: "equipment", touch: "equipment" };
  // Without a microphone nothing tells what the tracks run on.
  return { motors: aid, tracks: "none", touch: has("pads") ? "equipment" : aid };
}

/** Whether training aids are among them. @param {Rights} rights */
export const areAids = ({ motors, touch }) => motors === "aid" || touch === "aid";
