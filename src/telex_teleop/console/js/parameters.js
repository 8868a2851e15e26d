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

/**
 * The same, asked again while a busy machine does not answer in time.
 * @param {import("./bridge.js").Bridge} bridge
 * @param {string} name
 * @returns {Promise<any>} Rejected when it is refused, or the connection is lost.
 */
export async function awaitParameter(bridge, name) {
  for (;;) {
    try {
      return await getParameter(bridge, name);
    } catch (error) {
      if (/** @type {Error} */ (error).name !== "TimeoutError" || !bridge.connected) throw error;
    }
  }
}
