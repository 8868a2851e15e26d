// @ts-check
/** What the controls of a gamepad do: the file that joy_teleop reads, for the console. */

/**
 * @typedef {any} JoyAction  `{kind, …}`, as the video server tells it.
 *
 * @typedef {object} Binding
 * @property {number} deadzone        Share of the way that is rest.
 * @property {JoyAction} [action]     Of a button.
 * @property {JoyAction} [positive]   Of a stick's right or lower end,
 * @property {JoyAction} [negative]   and of the other one.
 * @property {number} [expo]          Share of the cubic part of a stick's response.
 * @property {number} [scale]         Of the full rate at the end of a stick's way.
 *
 * @typedef {Record<string, Binding>} Layer  By the name of the control.
 * @typedef {{name: string, arm_mode: string, plain: Layer, shifted: Layer}} PadMode
 * @typedef {{enable: string, shift: string, modes: PadMode[]}} PadMap
 */

/** @returns {Promise<PadMap>} */
export async function fetchPadMap() {
  const reply = await fetch("/joy_map.json", { cache: "no-store" });
  if (!reply.ok) throw new Error(`the video server says ${reply.status}`);
  return reply.json();
}

/**
 * What a control demands.
 * @param {Binding} binding
 * @param {number} value  -1 to 1
 * @returns {{action: JoyAction, amount: number}}  Amount 0 at rest, up to 1.
 */
export function demand({ action, positive, negative, deadzone, expo = 0, scale = 1 }, value) {
  const way = Math.max(0, (Math.abs(value) - deadzone) / (1 - deadzone));
  if (action !== undefined) return { action, amount: value > 0 ? Math.min(1, way) : 0 };
  const amount = Math.min(1, scale * ((1 - expo) * way + expo * way ** 3));
  return { action: value > 0 ? positive : negative, amount };
}
