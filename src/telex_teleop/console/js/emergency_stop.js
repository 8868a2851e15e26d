// @ts-check
/** The robot's emergency stop as a page sets it: what the network may have lost is sent again. */

import { text } from "./language.js";
import { TYPES } from "./robot.js";

export class EmergencyStop {
  /**
   * @param {import("./bridge.js").Bridge} bridge
   * @param {string} topic
   * @param {(sentence: string) => void} alarm
   */
  constructor(bridge, topic, alarm) {
    this._bridge = bridge;
    this._topic = topic;
    this._alarm = alarm;
    /** Whether it was set here, and the simulator has not said so yet. */
    this._isOpen = false;
    /** Whether it was released here, and the simulator has not said so yet: that it is set may be said of before. */
    this._isReleasing = false;
    /** Whether what was asked for last went out, as far as the browser knows. */
    this._isSent = false;
  }

  /** Advertise its topic, also for what is done while a call has the connection to itself. */
  advertise() {
    this._bridge.advertise(this._topic, TYPES.bool, { latch: true, urgent: true });
  }

  /** @param {boolean} data  Whether to stop. */
  set(data) {
    this._isOpen = data;
    this._send(data);
    if (!data) this._isReleasing = this._isSent;
    if (!this._isSent) this._warn();
  }

  /** Call it when the bridge is connected: what the last connection may have taken along goes out. */
  connected() {
    if (this._isOpen) this._send(true);
  }

  /** Call it when the connection is lost. A network that is gone takes messages for seconds before that shows. */
  lost() {
    if (this._isOpen && this._isSent) this._warn();
    this._isSent = this._isReleasing = false;
  }

  /** That it is not set may have been said before it was asked for. @param {any} status  telex_msgs/SimStatus */
  hear({ e_stop: isSet }) {
    if (!isSet) this._isReleasing = false;
    else if (!this._isReleasing) this._isOpen = false;
  }

  /** @param {boolean} data */
  _send(data) {
    this._isSent = this._bridge.publish(this._topic, { data });
  }

  _warn() {
    this._alarm(text("not connected: e-stop was NOT sent"));
  }
}
