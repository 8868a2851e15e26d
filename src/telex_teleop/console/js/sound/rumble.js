// @ts-check
/** Lets gamepads rumble that can. */

/**
 * @param {(Gamepad | null)[]} pads
 * @param {number} strong  0 to 1, of the heavy motor.
 * @param {number} weak    0 to 1, of the light one.
 * @param {number} duration  ms
 */
export function rumble(pads, strong, weak, duration) {
  const part = (/** @type {number} */ value) => (value > 0 ? Math.min(1, value) : 0);
  const [strongMagnitude, weakMagnitude] = [part(strong), part(weak)];
  if (strongMagnitude + weakMagnitude === 0) return;
  for (const pad of pads) {
    // A pad that was pulled out, or is busy, rumbles not; nobody has to know.
    pad?.vibrationActuator?.playEffect("dual-rumble", { duration, strongMagnitude, weakMagnitude })?.catch(() => {});
  }
}
