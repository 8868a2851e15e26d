// @ts-check
/** The last positions and efforts of the robot's joints. */

export class JointPositions {
  /** @param {import("./robot.js").GripperFacts | null} gripper  Its value is that of a joint, too. */
  constructor(gripper) {
    this._gripper = gripper;
    /** @type {Map<string, number>} */
    this._positions = new Map();
    /** @type {Map<string, number>} */
    this._efforts = new Map();
  }

  /** @param {any} states  sensor_msgs/JointState */
  set(states) {
    states.name.forEach((/** @type {string} */ name, /** @type {number} */ index) => {
      this._positions.set(name, states.position[index]);
      const effort = states.effort?.[index];
      if (Number.isFinite(effort)) this._efforts.set(name, effort);
    });
    if (this._gripper === null) return;
    const { name, measured_by: measured } = this._gripper;
    const bases = measured.map((base) => this._positions.get(base));
    if (bases.every(Number.isFinite)) {
      const sum = /** @type {number[]} */ (bases).reduce((total, angle) => total + angle, 0);
      this._positions.set(name, sum / bases.length);
    }
  }

  /** @param {string} joint  rad or m; undefined or null while it is not known. */
  position(joint) {
    return this._positions.get(joint);
  }

  /** @param {string} joint  Nm or N */
  effort(joint) {
    return this._efforts.get(joint);
  }
}
