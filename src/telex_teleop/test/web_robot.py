"""Plays the robot for the console's tests: its states, its cameras, an ear for commands."""

from __future__ import annotations

import math
import time
from pathlib import Path

import cv2
import numpy as np
import simplejpeg
import yaml
from waiting import wait_until

DRIVE = "/telex/track_teleop/cmd_vel"
ARM = "/telex/arm_teleop/delta_joint_cmds"
GRIPPER = "/telex/gripper_teleop/delta_joint_cmds"
FLIPPERS = "/telex/flipper_teleop/delta_joint_cmds"
PRESETS = "/telex/flipper_teleop/preset_cmds"
CONTACT = "/telex/sim/gripper_contact"
ESTOP = "/telex/e_stop"
NODES = ("arm_teleop", "gripper_teleop", "flipper_teleop", "track_teleop")
ARM_JOINTS = [
    "turret_joint",
    "shoulder_joint",
    "telescope_joint",
    "elbow_joint",
    "forearm_roll_joint",
    "wrist_pitch_joint",
    "gripper_roll_joint",
]
PRESET_NAMES = ["flat", "drive", "approach", "climb", "descend", "high", "folded"]
FINGERS = [f"{s}_finger_{p}_joint" for s in ("left", "right") for p in ("base", "middle", "tip")]
FLIPPER_JOINTS = [f"{e}_{s}_flipper_joint" for e in ("front", "rear") for s in ("left", "right")]
THUMBNAILS = ["arm", "gripper", "mast", "rear", "turret"]
LAMPS = ["front_left", "front_right", "rear_left", "rear_right", "turret_camera", "gripper"]
CONFIG = Path(__file__).resolve().parents[1] / "config"
ODOM = "/telex/track_controller/odom"
ODOMETRY = {
    "pose": {"pose": {"orientation": {"z": -math.sin(math.pi / 4), "w": math.cos(math.pi / 4)}}},
    "twist": {"twist": {"linear": {"x": 0.31}, "angular": {"z": -0.0175}}},
}
SHOULDER = """
  <joint name="shoulder_joint" type="revolute">
    <parent link="base_link"/><child link="shoulder_link"/>
    <origin xyz="0 0 0.2"/><axis xyz="0 1 0"/>
    <limit lower="-1.1" upper="0.9" effort="1" velocity="0.5"/>
    <safety_controller soft_lower_limit="-1.05" soft_upper_limit="0.85" k_velocity="1"/>
  </joint>
"""
HEAD_JOINTS = ["turret_camera_pan_joint", "turret_camera_tilt_joint"]
CAMERAS = {
    "front": "ahead",
    "rear": "back",
    "arm": "arm",
    "gripper": "tool",
    "turret": "look",
    "mast": "whole",
}
"""Cameras and their roles."""


def _link(name):
    return f'<link name="{name}"/>'


def _joint(name, parent, place=(0.0, 0.0, 0.0), kind="revolute"):
    """A joint without shape that carries the link of its name."""
    x, y, z = place
    limit = "" if kind == "continuous" else 'lower="-3" upper="3" '
    # The nodes' settings ask for joints that can brake within their leads.
    velocity = 3.0 if "finger" in name else 0.1 if kind == "prismatic" else 0.5
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/>'
        f'<child link="{name[:-6]}_link"/><origin xyz="{x} {y} {z}"/><axis xyz="0 1 0"/>'
        f'<limit {limit}effort="1" velocity="{velocity}"/></joint>{_link(name[:-6] + "_link")}'
    )


def _rest():
    """All that hangs on the hull and on the shoulder, of which nothing is to be seen."""
    parts, parent = [], "shoulder_link"
    for name in ARM_JOINTS:
        if name != "shoulder_joint":
            kind = {"telescope_joint": "prismatic", "elbow_joint": "continuous"}
            parts.append(_joint(name, parent, kind=kind.get(name, "revolute")))
            parent = f"{name[:-6]}_link"
    ends = f'<parent link="{parent}"/><child link="tool_link"/>'
    parts.append(f'{_link("tool_link")}<joint name="tool" type="fixed">{ends}</joint>')
    for name in FINGERS:
        parts.append(_joint(name, "tool_link", (0.0, 0.05 if "left" in name else -0.05, 0.0)))
    for name in FLIPPER_JOINTS:
        x, y = 0.3 if "front" in name else -0.3, 0.2 if "left" in name else -0.2
        parts.append(_joint(name, "base_link", (x, y, 0.0)))
    parent = "base_link"
    for name in HEAD_JOINTS:
        parts.append(_joint(name, parent))
        parent = f"{name[:-6]}_link"
    return "".join(parts)


URDF = f"""
<robot name="telex">
  <link name="base_link">
    <collision><geometry><box size="0.6 0.3 0.1"/></geometry></collision>
  </link>
  {SHOULDER}
  <link name="shoulder_link">
    <collision><origin xyz="0.3 0 0"/><geometry><box size="0.6 0.05 0.05"/></geometry></collision>
  </link>
  {_rest()}
</robot>
"""
JOINTS = ARM_JOINTS + FINGERS + FLIPPER_JOINTS
POSITIONS = [0.5, -1.0, 0.12, 2.0, 0.1, -0.5, -1e-6]
POSITIONS += [0.3, 0.3, -0.6, 0.3, 0.3, -0.6, 0.6, 0.61, -1.2, -1.2]
EFFORTS = [0.0] * 7 + [-2.0, 0.0, 0.0, -2.0] + [0.0] * 6
FINGER = {"base": 0.045, "middle": 0.075, "lean": 0.4363323, "pad": 0.024, "max_angle": 0.55}


def _replaced(values, name, value):
    """Values of all joints, with another one for a joint."""
    return [value if joint == name else at for joint, at in zip(JOINTS, values)]


def camera_picture(width=640, height=480, number=0):
    """Draw a floor, a horizon and two boxes: something that an operator could drive by."""
    picture = np.zeros((480, 640, 3), np.uint8)
    picture[:240], picture[240:] = (70, 80, 90), (75, 70, 60)
    for x in range(-20, 30):
        cv2.line(picture, (320, 240), (320 + x * 80, 480), (105, 100, 90), 1, cv2.LINE_AA)
    cv2.rectangle(picture, (100, 140), (220, 260), (90, 140, 130), -1)
    cv2.rectangle(picture, (420, 180), (500, 330), (200, 110, 40), -1)
    for each in range(number):
        cv2.circle(picture, (120 + 100 * each, 400), 40, (220, 60, 40), -1)
    return simplejpeg.encode_jpeg(cv2.resize(picture, (width, height)), quality=90)


def is_stop(command):
    """Tell whether a command lets everything rest that it is about."""
    if "preset" in command:
        return command["preset"] == ""
    if "velocities" in command:
        return not any(command["velocities"])
    return not any([*command["linear"].values(), *command["angular"].values()])


def describe(ros):
    """Set the parameters by which the console knows the robot."""
    parameters = {
        "robot_description": URDF,
        "gripper_controller/geometry": FINGER,
        "cameras/cameras": {
            name: {
                "frame": "turret_camera_tilt_link" if name == "turret" else "base_link",
                "role": role,
            }
            for name, role in CAMERAS.items()
        },
        "cameras/lamps": {name: {"frame": "base_link"} for name in LAMPS},
    }
    for node in NODES:
        parameters[node] = yaml.safe_load((CONFIG / f"{node}.yaml").read_text())
    presets = yaml.safe_load((CONFIG / "flipper_presets.yaml").read_text())
    parameters["flipper_teleop"].update(presets)
    poses = ("stow", "drive", "ready", "look_front", "floor_pick")
    parameters["arm_teleop"]["poses"] = {pose: dict.fromkeys(ARM_JOINTS, 0.0) for pose in poses}
    for name, value in parameters.items():
        ros.master.setParam(f"/telex/{name}", value)


class Robot:
    """Plays the robot's side: publishes states, hears commands."""

    def __init__(self, ros):
        self.probe = ros.probe()
        self.scale = 0.4
        for topic, kind in (
            (DRIVE, "geometry_msgs/Twist"),
            (ARM, "control_msgs/JointJog"),
            (GRIPPER, "control_msgs/JointJog"),
            (FLIPPERS, "control_msgs/JointJog"),
            (PRESETS, "telex_msgs/FlipperPresetHold"),
            (ESTOP, "std_msgs/Bool"),
        ):
            self.probe.subscribe(topic, kind)
        for node in NODES:
            self.probe.subscribe(f"/telex/{node}/speed_scale", "std_msgs/Float64")

    def publish_states(self):
        self._publish_joints(position=POSITIONS, effort=EFFORTS)
        self.probe.publish(ODOM, "nav_msgs/Odometry", ODOMETRY, rate=50)
        self.publish_sim()
        self.publish_camera("front", rate=15)
        for number, camera in enumerate(THUMBNAILS, start=1):
            self.publish_camera(camera, camera_picture(320, 240, number), rate=2)
        self.publish_camera("overview", rate=1)
        # that there are exercises
        idle = {"phase": "idle"}
        self.probe.publish("/telex/training/state", "telex_msgs/TrainingState", idle, latch=True)

    def publish_joint(self, name, position):
        """Publish another position of one joint."""
        self._publish_joints(position=_replaced(POSITIONS, name, position), effort=EFFORTS)

    def publish_effort(self, name, effort):
        """Publish another effort of one joint."""
        self._publish_joints(position=POSITIONS, effort=_replaced(EFFORTS, name, effort))

    def publish_velocity(self, name, velocity):
        """Publish that one joint moves."""
        velocities = _replaced([0.0] * len(JOINTS), name, velocity)
        self._publish_joints(position=POSITIONS, effort=EFFORTS, velocity=velocities)

    def _publish_joints(self, **states):
        states["name"] = JOINTS
        self.probe.publish("/telex/joint_states", "sensor_msgs/JointState", states, rate=50)

    def publish_camera(self, name, picture=None, rate=0):
        """Publish pictures at a rate, or one and then no more."""
        data = {"data": (picture or camera_picture()).hex()}
        topic = f"/telex/cameras/{name}/image_raw/compressed"
        self.probe.publish(topic, "sensor_msgs/CompressedImage", hex=data, rate=rate)

    def publish_sim(self, **changes):
        self.probe.do("publish", **self._sim(changes))

    @staticmethod
    def _sim(changes):
        """What the probe is to publish as the simulator's status."""
        status = {"real_time_factor": 0.998, "e_stop": False, "paused": False, **changes}
        topic = "/telex/sim/status"
        return {"topic": topic, "type": "telex_msgs/SimStatus", "message": status, "rate": 5}

    def publish_node_status(self, scale=0.4, arm_mode="JOINT", sim=None, **more):
        """Publish what the nodes say, and right after it, with `sim`, as `publish_sim` does."""
        orders = []

        def publish(topic, type_name, message, **options):
            orders.append({"topic": topic, "type": type_name, "message": message, **options})

        speed = {"speed_scale": scale, "min_speed_scale": 0.05, "max_speed_scale": 1.0, **more}
        for node, joints, limit, limited in (
            ("arm_teleop", ARM_JOINTS, 0.6, ["elbow_joint"]),
            ("gripper_teleop", [*FINGERS, "gripper"], 0.16, []),
            ("flipper_teleop", FLIPPER_JOINTS, 0.7, []),
        ):
            status = {"joint_names": joints, "max_velocity": [limit] * len(joints)}
            status.update(limited=limited, **speed)
            if node == "arm_teleop":
                status["mode"] = arm_mode
            topic = f"/telex/{node}/status"
            publish(topic, "telex_msgs/JointTeleopStatus", status, rate=10)
        presets = {"names": PRESET_NAMES, "descriptions": ["for " + name for name in PRESET_NAMES]}
        topic = "/telex/flipper_teleop/presets"
        publish(topic, "telex_msgs/FlipperPresets", presets, latch=True)
        drive = {"max_linear": 1.2, "max_angular": 1.0, "command": {"linear": {"x": 0.25}}}
        topic = "/telex/track_teleop/status"
        publish(topic, "telex_msgs/TrackTeleopStatus", {**drive, **speed}, rate=10)
        if sim is not None:
            orders.append(self._sim(sim))
        self.probe.do("publish_all", orders=orders)

    def silence_nodes(self):
        """Publish once more what the nodes say, and then no more; there are no presets."""
        for node in NODES[:-1]:
            self.probe.publish(f"/telex/{node}/status", "telex_msgs/JointTeleopStatus")
        self.probe.publish("/telex/track_teleop/status", "telex_msgs/TrackTeleopStatus")
        topic = "/telex/flipper_teleop/presets"
        self.probe.publish(topic, "telex_msgs/FlipperPresets", latch=True)

    def heard(self, topic):
        return self.probe.messages(topic)

    def forget(self):
        """Forget what was heard, once all that was sent has arrived, a stop the last of it."""

        def rests(topic):
            return self.is_quiet(topic, 0.03) and all(map(is_stop, self.heard(topic)[-1:]))

        wait_until(lambda: all(map(rests, (DRIVE, ARM, GRIPPER, FLIPPERS, PRESETS))), timeout=20.0)
        for messages in self.probe.heard.values():
            messages.clear()

    def wait_for(self, topic, count=1, timeout=20.0):
        wait_until(lambda: len(self.probe.heard[topic]) >= count, timeout=timeout)
        return self.heard(topic)

    def is_quiet(self, topic, period=0.3):
        """Tell whether nothing comes on a topic for a while (s)."""
        count = len(self.probe.heard[topic])
        time.sleep(period)
        return len(self.probe.heard[topic]) == count
