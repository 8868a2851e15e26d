// @ts-check
/** Shows which of the robot's nodes do not answer, and what that means for the operator. */

import { term, text } from "./language.js";
import { byId, setText } from "./panels.js";

export const MISSING_NODES = { topic: "bridge/missing_nodes", type: "telex_msgs/MissingNodes" };

/** What cannot be done without a node, by the last part of its name. */
const WITHOUT = /** @type {Record<string, string>} */ ({
  simulator: term("nothing moves; once it is back, the exercise begins anew"),
  controller_spawner: term("a simulator that crashes would get no controllers"),
  add_robot: term("a simulator that crashes would come back without this robot"),
  robot_state_publisher: term("other programs get no frames (/tf)"),
  cameras: term("there are no pictures"),
  video_server: term("there are no pictures"),
  transforms: term("other web clients get no transforms"),
  arm_teleop: term("the arm does not move"),
  gripper_teleop: term("the gripper does not move"),
  flipper_teleop: term("the flippers do not move"),
  track_teleop: term("the robot does not drive"),
  joy: term("the robot's own gamepad is not read"),
  joy_teleop: term("the robot's own gamepad moves nothing"),
});

export class Health {
  /**
   * @param {import("./status.js").StatusView} status
   * @param {(reason: string) => boolean} letGo
   */
  constructor(status, letGo) {
    this._status = status;
    this._letGo = letGo;
    /** @type {string[]} */
    this._missing = [];
  }

  /** @param {{names: string[]}} message  telex_msgs/MissingNodes */
  hear({ names }) {
    const missing = names.map((name) => name.slice(name.lastIndexOf("/") + 1));
    for (const name of missing.filter((each) => !this._missing.includes(each))) {
      if (!(name in WITHOUT)) {
        this._status.log(text("{node}, which is no part of the robot, has crashed", { node: name }));
        continue;
      }
      // The operator has to notice first; held keys would not be obeyed when the node is back.
      const news = text("{node} is missing: {harm}", { node: name, harm: text(WITHOUT[name]) });
      if (!this._letGo(news)) this._status.warn(news);
    }
    for (const name of this._missing.filter((each) => !missing.includes(each))) this._status.log(text("{node} is back", { node: name }));
    this._show(missing);
  }

  /** Without the bridge nothing is known. */
  forget() {
    this._show([]);
  }

  /** @param {string[]} missing */
  _show(missing) {
    this._missing = missing;
    const needed = missing.filter((name) => name in WITHOUT);
    const chip = byId("health");
    chip.hidden = needed.length === 0;
    chip.title = needed.map((name) => `${name}: ${text(WITHOUT[name])}`).join("\n");
    setText(chip, text("MISSING {nodes}", { nodes: needed.join(", ") }));
  }
}
