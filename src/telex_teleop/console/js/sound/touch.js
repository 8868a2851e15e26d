// @ts-check
/** What the gripper's pads feel, as knocks and slip. Numbers that are none are felt by nobody. */

const TOUCHED = 0.5; // N of a pad from which on it touches
const LET_GO = 0.2; // N below which it does not any more
const HARD = 40; // N at which a knock is as strong as any
const FAST = 0.1; // m/s at which slip is as strong as any

/** @typedef {{knock: number, slip: number}} Feeling  0 to 1: something was touched just now; something slips. */

export class Touch {
  constructor() {
    /** Pads that touch something. @type {Set<string>} */
    this._touching = new Set();
  }

  /**
   * @param {{slipping?: boolean, slip_speed?: number | null, pads?: {link: string, normal_force: number | null}[]}} contact
   *   telex_msgs/GripperContact
   * @returns {Feeling}
   */
  feel({ slipping = false, slip_speed: slip = 0, pads = [] }) {
    let knock = 0;
    for (const { link, normal_force: told } of pads) {
      const force = Number.isFinite(told) ? Number(told) : 0;
      if (force >= TOUCHED && !this._touching.has(link)) {
        this._touching.add(link);
        knock = Math.max(knock, Math.min(1, 0.2 + force / HARD));
      } else if (force < LET_GO) {
        this._touching.delete(link);
      }
    }
    return { knock, slip: slipping ? Math.min(1, 0.2 + (Number.isFinite(slip) ? Math.abs(Number(slip)) / FAST : 0)) : 0 };
  }
}
