// @ts-check
/** Subscribes to a topic as soon as somebody offers it: a bridge may never have heard of its type. */

const LOOK_PERIOD = 5000; // ms between two looks at whether it is there

export class WhenOffered {
  /**
   * @param {import("../bridge.js").Bridge} bridge
   * @param {{topic: string, type: string, throttle: number, heard: (message: any) => void}} subscription
   */
  constructor(bridge, subscription) {
    this._bridge = bridge;
    this._subscription = subscription;
    this._isSubscribed = false;
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this._timer = undefined;
  }

  /** To be called after every new connection. */
  async connected() {
    clearTimeout(this._timer);
    if (this._isSubscribed) return; // the bridge sees to it
    if (await this._isOffered()) {
      this._isSubscribed = true;
      this._bridge.subscribe(this._subscription);
    } else {
      clearTimeout(this._timer);
      this._timer = setTimeout(() => this.connected(), LOOK_PERIOD);
    }
  }

  async _isOffered() {
    try {
      return (await this._bridge.call("/rosapi/topic_type", { topic: this._subscription.topic })).type !== "";
    } catch {
      return false; // not connected, perhaps
    }
  }
}
