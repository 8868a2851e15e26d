/** A few actions of each kind, as /actions.json has them. */

import { Vocabulary } from "../../console/js/vocabulary.js";

const ALL = ["DRIVE", "JOINT", "CARTESIAN", "CAMERA"];

/** What the page is told of a robot with these joints. @type {import("../../console/js/robot.js").Facts} */
export const facts = {
  cameras: {},
  moves: { arm: ["turret_joint", "pan_joint"], gripper: ["near_joint", "far_joint"], flipper: ["a_joint", "b_joint", "c_joint", "d_joint"] },
  sides: { left: ["a_joint", "c_joint", "near_joint"], right: ["b_joint", "d_joint", "far_joint"] },
  gripper: { name: "hand", measured_by: ["near_joint", "far_joint"], geometry: null },
  odometry: "base/odom",
};

/** @param {string} name @param {any} does @param {string | null} code @param {string[]} [modes] @param {string[]} [more_codes] */
const action = (name, does, code, modes = ALL, more_codes = []) => ({
  name, does, code, modes, more_codes, cap: code, title: name.replace(":", " "), label: name.split(":")[1] ?? name, row: name.split(":")[0], group: "all", button: true,
});

export const made = () => new Vocabulary(/** @type {any} */ ({
  speed_step: 0.1, zoom_rate: 0.8, max_zoom: 6, lengths: ["telescope_joint"], modes: ALL.map((name) => ({ name, note: "" })),
  actions: [
    action("estop", { kind: "command", name: "e-stop" }, "Escape"),
    action("faster", { kind: "command", name: "faster" }, "Equal", ALL, ["NumpadAdd"]),
    action("release", { kind: "command", name: "release e-stop" }, null),
    action("drive:forward", { kind: "drive", linear: 1, angular: 0 }, "KeyW"),
    action("drive:left", { kind: "drive", linear: 0, angular: 1 }, "KeyA"),
    action("front:up", { kind: "jog", node: "flipper", joints: ["a_joint", "b_joint"], sign: 1 }, "KeyR"),
    action("rear:up", { kind: "jog", node: "flipper", joints: ["c_joint", "d_joint"], sign: 1 }, "KeyT"),
    action("side:left", { kind: "side", name: "left" }, "KeyQ"),
    action("preset:0", { kind: "preset", name: "flat" }, "Digit1"),
    action("preset:1", { kind: "preset", name: "climb" }, "Digit2"),
    action("turret:left", { kind: "jog", node: "arm", joints: ["turret_joint"], sign: 1 }, "KeyJ", ["JOINT"]),
    action("tool_y:left", { kind: "tool", axis: "y", sign: 1 }, "KeyJ", ["CARTESIAN"]),
    action("pose:stow", { kind: "pose", name: "stow" }, "KeyZ", ["JOINT", "CARTESIAN"]),
    action("look:left", { kind: "jog", node: "arm", joints: ["pan_joint"], sign: 1 }, "ArrowLeft"),
    action("look:near", { kind: "zoom", sign: 1 }, "PageUp"),
    action("lamps:front", { kind: "lamps", names: ["front_left", "front_right"] }, "Home"),
    action("camera_pan:left", { kind: "jog", node: "arm", joints: ["pan_joint"], sign: 1 }, "KeyJ", ["CAMERA"]),
  ],
}));
