"""The robot cannot pass through itself or the floor, and touches nothing that it does not touch."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pybullet
import pytest
from geometry_msgs.msg import Twist
from std_msgs.msg import Float64

from telex_control.common.params import ConfigError, read_config
from telex_control.urdf.joints import joints, parse_urdf
from telex_sim.offline.simulation import OfflineSimulation, shipped_config
from telex_sim.robot.self_collision import SelfCollisionConfig

pytestmark = pytest.mark.slow

CORNERS = [f"{end}_{side}" for end in ("front", "rear") for side in ("left", "right")]
PADS = frozenset(("left_finger_tip_link", "right_finger_tip_link"))
STIFF = 2.0e-3
"""How far solid parts may sink into each other (m)."""

BLOWN_UP = 4.0
"""No joint gets so fast by pressing (rad/s)."""


def degrees(**angles):
    return {f"{name}_joint": math.radians(angle) for name, angle in angles.items()}


class Contacts:
    """A robot whose contacts are watched in every step."""

    def __init__(self, robot, pose):
        poses = dict(shipped_config().start.poses)
        poses["test"] = {**poses["look_front"], **pose}
        self.robot = robot(start__poses=poses, start__pose="test")
        body = self.robot.simulation.body
        self.uid, self.client = body.uid, body.client
        self.names = {index: link for link, index in body.links.items()}
        self.depth = {}
        self.force = {}
        self.fastest = 0.0

    def run(self, seconds):
        simulation = self.robot.simulation
        for _ in range(round(seconds / simulation.config.timing.step_size)):
            simulation.step()
            for contact in pybullet.getContactPoints(self.uid, physicsClientId=self.client):
                self._note(contact)
        for joint in simulation.hw._all:
            if "track" not in joint.description.name:
                self.fastest = max(self.fastest, abs(joint.state.velocity))

    def _note(self, contact):
        if contact[9] <= 0.0:
            return
        mine = [
            self.names[link] for body, link in zip(contact[1:3], contact[3:5]) if body == self.uid
        ]
        pair = frozenset(mine if len(mine) == 2 else (*mine, "floor"))
        self.depth[pair] = max(self.depth.get(pair, 0.0), -contact[8])
        self.force[pair] = max(self.force.get(pair, 0.0), contact[9])

    def push(self, joint, target, velocity):
        """Lead a joint's reference to `target`, and keep it there for a while."""
        command = self.robot.node.advertise(f"{joint}_position_controller/command", Float64)
        position = self.robot.positions()[f"{joint}_joint"]
        while position != target:
            step = 0.01 * velocity
            position += max(-step, min(step, target - position))
            command.publish(Float64(position))
            self.run(0.01)
        self.run(0.6)

    def of(self, *links):
        return {pair: depth for pair, depth in self.depth.items() if pair & set(links)}


@pytest.fixture
def contacts(robot):
    return lambda **pose: Contacts(robot, degrees(**pose))


# ---- the list of disabled pairs


def pair(*links, reason="never"):
    return {"links": list(links), "reason": reason, "explanation": "for the test"}


@pytest.mark.parametrize(
    ("params", "named"),
    [
        ({"disabled_pairs": [pair("a", "a")]}, "links are 'a' twice"),
        ({"disabled_pairs": [pair("a", "b"), pair("b", "a")]}, r"disabled_pairs\[1\].*named twice"),
        ({"disabled_pairs": [pair("a", "b", reason="ugly")]}, "reason is 'ugly'"),
        ({"disabled_pairs": [{"links": ["a", "b"], "reason": "never"}]}, "explanation is missing"),
        ({"disabled_pairs": [pair("a", "b", "c")]}, "has 3 elements"),
        ({"pairs": []}, "pairs is unknown"),
    ],
)
def test_wrong_lists_are_refused_by_name(params, named):
    with pytest.raises(ConfigError, match=named):
        read_config(SelfCollisionConfig, params, "self_collision")


def test_a_misspelt_link_is_refused_and_one_of_another_variant_is_not():
    config = read_config(
        SelfCollisionConfig, {"disabled_pairs": [pair("hull", "arm")]}, "self_collision"
    )
    config.check_links(["hull", "arm", "more"])
    with pytest.raises(ConfigError, match=r"disabled_pairs\[0\]: the robot has no link 'arm'"):
        config.check_links(["hull", "more"])
    variants = SelfCollisionConfig(("arm",), config.disabled_pairs)
    variants.check_links(["hull", "more"])


def test_the_simulator_refuses_a_misspelt_link(urdf):
    wrong = {"disabled_pairs": [pair("base_link", "turrent_link")]}
    with pytest.raises(ConfigError, match="turrent_link"):
        OfflineSimulation(urdf, self_collision=wrong)


def test_pairs_that_never_touch_do_not_in_a_thousand_configurations(robot, urdf):
    tested = robot()
    body = tested.simulation.body
    limits = joints(parse_urdf(urdf))
    generator = np.random.default_rng(7)
    never = [
        each
        for each in tested.simulation.config.self_collision.disabled_pairs
        if each.reason == "never"
    ]
    assert never
    for _ in range(1000):
        for name, limit in limits.items():
            if "track" in name or "finger" in name:
                continue
            at_stop = generator.random() < 0.2
            ends = (limit.lower, limit.upper)
            position = generator.choice(ends) if at_stop else generator.uniform(*ends)
            reset(body, name, position)
        opening = generator.uniform(-0.05, 0.56)
        for side, (part, ratio) in itertools.product(
            ("left", "right"), (("base", 1), ("middle", 1), ("tip", -2))
        ):
            reset(body, f"{side}_finger_{part}_joint", ratio * opening)
        for each in never:
            first, second = (body.links[link] for link in each.links)
            assert not pybullet.getClosestPoints(
                body.uid, body.uid, 0.0, first, second, physicsClientId=body.client
            ), each.links


def reset(body, joint, position):
    pybullet.resetJointState(body.uid, body.joints[joint], position, physicsClientId=body.client)


# ---- no contact where there is none


@pytest.mark.parametrize("pose", ["stow", "drive", "ready", "look_front", "floor_pick"])
def test_in_the_named_poses_only_closed_pads_touch(robot, pose):
    watched = Contacts(robot, shipped_config().start.poses[pose])
    watched.run(1.0)
    own = {pair for pair in watched.force if not pair & {"floor"}}
    assert own <= {PADS}
    assert watched.force.get(PADS, 0.0) < 20.0


def test_flippers_and_wheels_turn_without_touching_the_hull(contacts):
    watched = contacts()
    watched.run(0.3)
    drive = watched.robot.node.advertise("track_controller/cmd_vel", Twist)
    message = Twist()
    message.linear.x = 0.4
    commands = [
        watched.robot.node.advertise(f"{corner}_flipper_position_controller/command", Float64)
        for corner in CORNERS
    ]
    for angle in np.concatenate([np.linspace(0.0, 1.9, 100), np.linspace(1.9, -0.4, 120)]):
        drive.publish(message)
        for command in commands:
            command.publish(Float64(angle))
        watched.run(0.03)
    assert {pair for pair in watched.force if not pair & {"floor"}} <= {PADS}


# ---- the arm stops where something is in its way


@pytest.mark.parametrize(
    ("start", "target"),
    [
        ({"shoulder": -150, "elbow": -60, "wrist_pitch": 0}, -160),
        ({"shoulder": -60, "elbow": 120, "wrist_pitch": 0}, 169),
    ],
    ids=["rear deck", "front deck"],
)
def test_the_arm_does_not_pass_through_the_hull(contacts, start, target):
    watched = contacts(**start)
    watched.run(0.3)
    watched.push("elbow", math.radians(target), 0.6)
    met = watched.of("base_link")
    assert met
    assert max(met.values()) < STIFF
    left = abs(watched.robot.positions()["elbow_joint"] - math.radians(target))
    assert left > math.radians(3)
    assert watched.fastest < BLOWN_UP


def test_the_arm_does_not_pass_through_the_floor(contacts):
    watched = contacts(shoulder=-40, elbow=40, wrist_pitch=0)
    watched.run(0.3)
    # It presses until it lifts the robot.
    watched.push("shoulder", math.radians(10), 0.3)
    met = {pair: d for pair, d in watched.of("floor").items() if "flipper" not in str(set(pair))}
    assert met
    assert max(met.values()) < STIFF
    poses = watched.robot.simulation.link_poses()
    index = watched.robot.simulation.body.link_names().index("tool_link")
    assert poses[7 * index + 2] > 0.0
    assert watched.fastest < BLOWN_UP


@pytest.mark.parametrize("corner", CORNERS)
def test_the_arm_does_not_pass_through_a_flipper(contacts, corner):
    end, side = corner.split("_")
    sign = 1 if side == "left" else -1
    away, behind = (100, 20) if end == "front" else (125, 170)
    raised = {f"{corner}_flipper": 69}
    watched = contacts(turret=sign * away, shoulder=2, elbow=0, wrist_pitch=0, **raised)
    watched.run(0.3)
    watched.push("turret", math.radians(sign * behind), 0.3)
    met = watched.of(f"{corner}_flipper_link")
    met.pop(frozenset((f"{corner}_flipper_link", "floor")), None)
    assert met
    # The belt gives way by its own stiffness; nothing else does.
    stiffness = watched.robot.simulation.config.tracks.contact_stiffness
    for pair, depth in met.items():
        assert depth < watched.force[pair] / stiffness + 0.5e-3
        assert depth < 10.0e-3
    left = abs(watched.robot.positions()["turret_joint"] - math.radians(sign * behind))
    assert left > math.radians(3)
    assert watched.fastest < BLOWN_UP


def test_an_arm_that_presses_on_a_flipper_does_not_drive_the_robot(contacts):
    watched = contacts(turret=-20, shoulder=-30, elbow=0, wrist_pitch=0, front_right_flipper=57)
    watched.run(0.3)
    watched.push("shoulder", math.radians(-2), 0.3)
    assert watched.of("front_right_flipper_link")
    base = watched.robot.simulation.body.base_pose
    # the flipper's controller takes its time to bear the load
    watched.run(1.0)
    before = base()
    watched.run(1.0)
    assert math.dist(before[0], base()[0]) < 1e-3
    drive = watched.robot.node.advertise("track_controller/cmd_vel", Twist)
    message = Twist()
    message.linear.x = 0.3
    for _ in range(40):
        drive.publish(message)
        watched.run(0.05)
    after = base()
    assert after[0][0] - before[0][0] == pytest.approx(0.6, rel=0.1)
    assert abs(after[0][1] - before[0][1]) < 0.05


def test_fingers_that_close_on_each_other_stop_at_their_pads(contacts):
    watched = contacts()
    watched.run(0.2)
    commands = {
        (side, part): watched.robot.node.advertise(
            f"{side}_finger_{part}_position_controller/command", Float64
        )
        for side in ("left", "right")
        for part in ("base", "middle", "tip")
    }
    for angle in np.concatenate([np.linspace(0.0, 0.3, 30), np.linspace(0.3, -0.045, 60)]):
        for (_, part), command in commands.items():
            command.publish(Float64(-2.0 * angle if part == "tip" else angle))
        watched.run(0.02)
    watched.run(0.5)
    assert watched.force[PADS] > 50.0
    assert watched.depth[PADS] < STIFF
    positions = watched.robot.positions()
    for side in ("left", "right"):
        assert positions[f"{side}_finger_base_joint"] > -0.02
    speeds = [abs(joint.state.velocity) for joint in watched.robot.simulation.hw._all]
    assert max(speeds) < 0.01
