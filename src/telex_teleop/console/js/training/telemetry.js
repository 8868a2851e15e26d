// @ts-check
/** What the operator sees, told to the recording: the camera of the large view, how old its pictures are, and which aids are on. */

import { TYPES } from "./client.js";

const PERIOD = 500; // ms

/**
 * Tell it for as long as the page lives.
 * @param {import("../bridge.js").Bridge} bridge
 * @param {(name: string) => string} topic
 * @param {() => {view: string, picture_age: number | null, aids?: Record<string, boolean>} | null} look  Camera, age (s) of the picture
 *   that is painted, and the aids that are on by name: true for a training aid, which stands in for equipment that the robot lacks; null:
 *   this page does not drive, and tells nothing.
 */
export function tellTelemetry(bridge, topic, look) {
  const name = topic("console/telemetry");
  bridge.advertise(name, TYPES.telemetry);
  setInterval(() => {
    if (!bridge.connected || document.hidden) return;
    const seen = look();
    if (seen === null) return;
    const { view, picture_age: age, aids } = seen;
    const trip = bridge.usualTrip;
    const told = {
      view,
      ...(age === null ? {} : { picture_age: age }),
      ...(trip === null ? {} : { round_trip: trip / 1000 }),
      ...(aids === undefined ? {} : { aids }),
    };
    bridge.publish(name, { data: JSON.stringify(told) });
  }, PERIOD);
}
