// @ts-check
/** Publishes what the operator sees and holds, for the recording and the instructor: large view, age of its pictures, aids, actions. */

import { TYPES } from "./client.js";

const PERIOD = 500; // ms
const SOONEST = 100; // ms between two messages at least, however often something is pressed

/**
 * Camera, age (s) of its painted picture, names of actions, and the aids that are on by name: true for a training aid, which stands in for
 * equipment that the robot lacks.
 * @typedef {{view: string, picture_age: number | null, held: string[], aids?: Record<string, boolean>}} Seen
 */

/**
 * Tell it for as long as the page lives.
 * @param {import("../bridge.js").Bridge} bridge
 * @param {(name: string) => string} topic
 * @param {() => Seen | null} look  Null: this page does not drive, and tells nothing.
 * @returns {() => void} Publishes soon, because the held keys have changed.
 */
export function tellTelemetry(bridge, topic, look) {
  const name = topic("console/telemetry");
  bridge.advertise(name, TYPES.telemetry);
  let told = -Infinity;
  const tell = () => {
    if (!bridge.connected || document.hidden) return;
    const seen = look();
    if (seen === null) return;
    told = performance.now();
    const { view, picture_age: age, held, aids } = seen;
    const trip = bridge.usualTrip;
    const data = {
      view,
      held,
      ...(age === null ? {} : { picture_age: age }),
      ...(trip === null ? {} : { round_trip: trip / 1000 }),
      ...(aids === undefined ? {} : { aids }),
    };
    bridge.publish(name, { data: JSON.stringify(data) });
  };
  setInterval(tell, PERIOD);
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  let due;
  return () => {
    clearTimeout(due);
    due = setTimeout(tell, Math.max(0, told + SOONEST - performance.now()));
  };
}
