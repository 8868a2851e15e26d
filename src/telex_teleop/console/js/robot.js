// @ts-check
/** What the console knows of the robot: its nodes, and joints that it shows but does not move by themselves. */

/** Nodes that take joint commands; their topics are `<node>/delta_joint_cmds`, `/speed_scale`, `/status`. */
export const JOINT_NODES = ["arm_teleop", "gripper_teleop", "flipper_teleop"];

/** Node that takes presets, on `<node>/preset_cmds`, and says on `<node>/presets` which there are. */
export const FLIPPER_NODE = "flipper_teleop";

export const TRACK_NODE = "track_teleop";

export const TYPES = {
  bool: "std_msgs/Bool",
  flipperPresetHold: "telex_msgs/FlipperPresetHold",
  flipperPresets: "telex_msgs/FlipperPresets",
  jointJog: "control_msgs/JointJog",
  jointStates: "sensor_msgs/JointState",
  jointStatus: "telex_msgs/JointTeleopStatus",
  number: "std_msgs/Float64",
  simStatus: "telex_msgs/SimStatus",
  trackStatus: "telex_msgs/TrackTeleopStatus",
  twist: "geometry_msgs/Twist",
};

/** Joint by which gripper_teleop opens and closes all fingers together. */
export const GRIPPER_JOINT = "gripper";

/** Joints whose angle shows how far the gripper is open. */
export const FINGER_BASES = ["left_finger_base_joint", "right_finger_base_joint"];

/** @param {string} side */
export const fingerJoints = (side) => ["base", "middle", "tip"].map((part) => `${side}_finger_${part}_joint`);
