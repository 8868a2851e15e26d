/**
 * An acceptance client: commands the running simulator with npm's roslib, and tells the outcome.
 *
 *     node roslib_robot.mjs URL GROUPS
 *
 * GROUPS is the parameter controller_groups as JSON. Prints a JSON object: what came of each step.
 */
import ROSLIB from "roslib-1";

const TIMEOUT = 50000; // ms for all
const [url, groups] = process.argv.slice(2);
const { actions, manual } = JSON.parse(groups);
const ARM = [
  "turret_joint", "shoulder_joint", "telescope_joint", "elbow_joint", "forearm_roll_joint", "wrist_pitch_joint",
  "gripper_roll_joint",
];

const ros = new ROSLIB.Ros({ url });
await new Promise((resolve, reject) => {
  ros.on("connection", resolve);
  ros.on("error", reject);
});
setTimeout(() => {
  console.error("it takes too long");
  process.exit(1);
}, TIMEOUT);

function hear(name, messageType, enough) {
  const topic = new ROSLIB.Topic({ ros, name, messageType });
  return new Promise((resolve) => topic.subscribe((message) => {
    if (!enough(message)) return;
    topic.unsubscribe();
    resolve(message);
  }));
}

function call(name, serviceType, fields = {}) {
  const service = new ROSLIB.Service({ ros, name, serviceType });
  return new Promise((resolve, reject) => service.callService(new ROSLIB.ServiceRequest(fields), resolve, reject));
}

function perform(serverName, actionName, goalMessage) {
  const actionClient = new ROSLIB.ActionClient({ ros, serverName, actionName });
  const goal = new ROSLIB.Goal({ actionClient, goalMessage });
  return new Promise((resolve) => {
    goal.on("result", resolve);
    goal.send();
  });
}

const change = (start, stop) => call(
  "/telex/controller_manager/switch_controller", "controller_manager_msgs/SwitchController",
  { start_controllers: start, stop_controllers: stop, strictness: 2 },
);
const paused = async (wanted) => {
  await call(`/telex/sim/${wanted ? "pause" : "unpause"}`, "std_srvs/Empty");
  return (await hear("/telex/sim/status", "telex_msgs/SimStatus", (status) => status.paused === wanted)).paused;
};
const hasArm = ({ name }) => ARM.every((joint) => name.includes(joint));

const description = new ROSLIB.Param({ ros, name: "/telex/robot_description" });
const states = await hear("/telex/joint_states", "sensor_msgs/JointState", hasArm);
const outcome = {
  joints: states.name.length,
  description: (await new Promise((resolve) => description.get(resolve))).includes("<robot"),
  paused: [await paused(true), await paused(false)],
};
await change(actions, manual);
const positions = ARM.map((joint) => states.position[states.name.indexOf(joint)]);
positions[0] -= 0.15;
const points = [{ positions, time_from_start: { secs: 1, nsecs: 0 } }];
outcome.trajectory = (await perform(
  "/telex/arm_trajectory_controller/follow_joint_trajectory", "control_msgs/FollowJointTrajectoryAction",
  { trajectory: { joint_names: ARM, points } },
)).error_code;
outcome.gripper = (await perform(
  "/telex/gripper_controller/gripper_cmd", "control_msgs/GripperCommandAction",
  { command: { position: 0.08, max_effort: 50 } },
)).reached_goal;
await change(manual, actions);
console.log(JSON.stringify(outcome));
process.exit(0);
