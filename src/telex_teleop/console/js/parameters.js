// @ts-check
/** Parameters of the robot, by the bridge. */

/**
 * @param {import("./bridge.js").Bridge} bridge
 * @param {string} name
 * @returns {Promise<any>} Its value; null if it is not set. Rejected when the bridge does not answer.
 */
export async function getParameter(bridge, name) {
  const { value } = await bridge.call("/rosapi/get_param", { name, default: "null" });
  return JSON.parse(value);
}
