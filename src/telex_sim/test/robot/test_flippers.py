"""The shipped flippers: they lift the robot, hold their angle, stall, and never pass each other."""

from __future__ import annotations

import itertools
import math
import re

import pybullet
import pytest
from std_msgs.msg import Float64

from telex_control.urdf.joints import joints, parse_urdf
from telex_sim.offline.simulation import OfflineSimulation, shipped_config

pytestmark = pytest.mark.slow

STEP = 0.002
RATE = 1.0
"""The flippers' rated velocity (rad/s)."""

EFFORT = 300.0
"""And their effort limit (N m)."""

OVERSPEED = 1.05 * RATE + EFFORT / 0.8 * STEP
"""A drive of 0.8 kg m2 cuts out above its rated velocity, one step late (rad/s)."""

FRONT = ("front_left", "front_right")
REAR = ("rear_left", "rear_right")
FLIPPERS = FRONT + REAR
PRECISE = math.radians(0.03)
"""How near a flipper comes to its angle under load (rad)."""


class Flippers:
    """A robot whose flippers are commanded as scripts do, straight at their controllers."""

    def __init__(self, tested):
        self.simulation = tested.simulation
        self.body = tested.simulation.body
        self.states = {
            name: self.simulation.hw.joint_state(f"{name}_flipper_joint") for name in FLIPPERS
        }
        self._commands = {
            name: tested.node.advertise(f"{name}_flipper_position_controller/command", Float64)
            for name in FLIPPERS
        }
        self.fastest = self.strongest = 0.0
        self.depth = {}
        self._links = {index: link for link, index in self.body.links.items()}

    def send(self, angle, names=FLIPPERS):
        for name in names:
            self._commands[name].publish(Float64(angle))

    def run(self, seconds, each_step=None):
        for _ in range(round(seconds / STEP)):
            self.simulation.step()
            for state in self.states.values():
                self.fastest = max(self.fastest, abs(state.velocity))
                self.strongest = max(self.strongest, abs(state.effort))
            if each_step is not None:
                each_step()

    def note_contacts(self):
        """Note how deep flippers stand in each other (m)."""
        for contact in pybullet.getContactPoints(
            self.body.uid, self.body.uid, physicsClientId=self.body.client
        ):
            pair = frozenset((self._links[contact[3]], self._links[contact[4]]))
            if contact[9] > 0.0 and any("flipper" in link for link in pair):
                self.depth[pair] = max(self.depth.get(pair, 0.0), -contact[8])

    def error(self, angle, names=FLIPPERS):
        return max(abs(self.states[name].position - angle) for name in names)

    def carry(self, mass):
        """Put a load into the gripper (kg)."""
        link = self.body.links["gripper_link"]
        uid, client = self.body.uid, self.body.client
        own = pybullet.getDynamicsInfo(uid, link, physicsClientId=client)[0]
        pybullet.changeDynamics(uid, link, mass=own + mass, physicsClientId=client)

    def pitch(self):
        x, y, z, w = self.body.base_pose()[1]
        return math.asin(2.0 * (w * y - z * x))

    def height(self):
        return self.body.base_pose()[0][2]


@pytest.fixture
def flippers(robot):
    """Makes robots in a named pose, but for their flippers."""

    def make(angle=0.0, pose="drive", **changes):
        return Flippers(robot(**posed(angle, pose), **changes))

    return make


def posed(angle, pose="drive"):
    poses = dict(shipped_config().start.poses)
    poses["test"] = {**poses[pose], **{f"{name}_flipper_joint": angle for name in FLIPPERS}}
    return {"start__poses": poses, "start__pose": "test"}


IN_THE_AIR = {"fixed_base": True, "start__place": [0.0, 0.0, 2.0, 0.0]}


# ---- on the four tips


@pytest.mark.parametrize(
    ("pose", "load"),
    [("drive", 0.0), ("look_front", 10.0)],
    ids=["arm folded", "10 kg before the hull"],
)
def test_four_flippers_lift_the_robot_and_hold_it(flippers, pose, load):
    tested = flippers(pose=pose)
    tested.carry(load)
    tested.run(0.3)
    tested.send(-1.2)
    tested.run(3.0)
    # axles over the tips' axles by 0.44 m times the sine of the middle line's angle
    tips = 0.070 + 0.440 * math.sin(1.2 + math.asin(0.040 / 0.440))
    assert tested.height() == pytest.approx(tips, abs=0.005)
    assert abs(tested.pitch()) < math.radians(1.0)
    tested.run(2.0)
    efforts = {name: state.effort for name, state in tested.states.items()}
    errors = []
    tested.run(0.5, lambda: errors.append(tested.error(-1.2)))
    assert max(errors) < PRECISE
    for name, state in tested.states.items():
        assert state.effort == pytest.approx(efforts[name], abs=10.0), name


def test_standing_up_is_led_and_smooth(flippers):
    tested = flippers()
    tested.run(0.3)
    tested.fastest = tested.strongest = 0.0
    tested.send(-1.2)
    before = {name: state.effort for name, state in tested.states.items()}
    steps = []

    def note():
        for name, state in tested.states.items():
            steps.append(abs(state.effort - before[name]))
            before[name] = state.effort

    tested.run(1.6, note)
    assert tested.fastest < 1.1 * RATE
    # more than half of it, and a reserve
    assert 0.4 * EFFORT < tested.strongest < 0.75 * EFFORT
    assert max(steps) < 40.0


def test_flippers_that_meet_the_ground_at_full_speed_do_not_hammer_it(flippers):
    tested = flippers(0.6)
    tested.run(0.3)
    tested.send(-1.4)
    tested.run(1.0)
    loads = []

    def note():
        contacts = pybullet.getContactPoints(tested.body.uid, physicsClientId=tested.body.client)
        loads.append(sum(contact[9] for contact in contacts))

    tested.run(0.3, note)
    # It is being lifted by them, and weighs 76 kg.
    assert min(tested.states[name].velocity for name in FLIPPERS) < -0.9
    assert 600.0 < sum(loads) / len(loads) < 900.0
    assert max(abs(now - last) for last, now in zip(loads, loads[1:])) < 200.0


def test_a_sudden_load_hardly_bends_them(flippers):
    tested = flippers(-0.5, "look_front", start__height=0.32)
    tested.run(1.0)
    tested.carry(20.0)
    errors = []
    tested.run(1.5, lambda: errors.append(tested.error(-0.5)))
    assert max(errors) < math.radians(0.1)
    assert max(errors[-250:]) < PRECISE


# ---- alone


def test_a_free_flipper_follows_without_overshoot(flippers):
    tested = flippers(**IN_THE_AIR)
    tested.run(0.2)
    highest = 0.0

    def note():
        nonlocal highest
        highest = max(highest, tested.states["front_left"].position)

    tested.send(1.0, ["front_left"])
    tested.run(2.6, note)
    assert highest < 1.0 + math.radians(0.2)
    assert tested.error(1.0, ["front_left"]) < PRECISE
    assert tested.fastest < 1.05 * RATE


def test_a_blocked_flipper_stalls_and_is_not_flung_when_it_comes_free(flippers):
    tested = flippers(**IN_THE_AIR)
    tested.run(0.2)
    client = tested.body.client
    shape = pybullet.createCollisionShape(
        pybullet.GEOM_BOX, halfExtents=(0.05, 0.10, 0.02), physicsClientId=client
    )
    obstacle = pybullet.createMultiBody(
        0.0, shape, basePosition=(0.72, 0.1725, 2.17), physicsClientId=client
    )
    flipper = tested.states["front_left"]
    tested.send(1.2, ["front_left"])
    tested.run(2.0)
    stalled = flipper.position
    assert 0.1 < stalled < 0.5
    assert flipper.effort == pytest.approx(EFFORT)
    tested.fastest = 0.0
    tested.run(0.5)
    assert flipper.position == pytest.approx(stalled, abs=1e-3)
    assert tested.fastest < 0.01
    pybullet.removeBody(obstacle, physicsClientId=client)
    highest = 0.0

    def note():
        nonlocal highest
        highest = max(highest, flipper.position)

    tested.run(2.0, note)
    assert tested.fastest < OVERSPEED
    assert highest < 1.2 + math.radians(1.0)
    assert tested.error(1.2, ["front_left"]) < PRECISE


# ---- front and rear of a side


def with_lower_limit(urdf, lower):
    """Return the robot with flippers that could turn further down than the shipped ones."""

    def change(found):
        text = re.sub(r' lower="[^"]*"', f' lower="{lower}"', found.group())
        return re.sub(r'soft_lower_limit="[^"]*"', f'soft_lower_limit="{lower + 0.02}"', text)

    return re.sub(r'<joint name="\w+_flipper_joint".*?</joint>', change, urdf, flags=re.DOTALL)


DRIVE, MIDDLE = 300.0, 0.2  # Nm, m


ORDERS = {
    "together": [FLIPPERS],
    "front first": [FRONT, REAR],
    "rear first": [REAR, FRONT],
    "crosswise": [("front_left", "rear_right"), ("rear_left", "front_right")],
}


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("inward", [-math.pi, math.pi], ids=["below", "above"])
def test_flippers_of_a_side_cannot_be_commanded_into_each_other(flippers, order, inward):
    tested = flippers(math.copysign(1.4, inward), **IN_THE_AIR)
    for names in ORDERS[order]:
        tested.send(inward, names)
        tested.run(1.0, tested.note_contacts)
    assert tested.depth == {}
    limits = joints(parse_urdf(tested.simulation.robots[0].urdf))
    for name in itertools.chain(*ORDERS[order]):
        limit = limits[f"{name}_flipper_joint"]
        end = limit.lower if inward < 0.0 else limit.upper
        assert tested.states[name].position == pytest.approx(end, abs=0.012), name


@pytest.mark.parametrize("order", ["together", "front first"])
def test_flippers_that_reach_each_other_do_not_pass(urdf, order):
    robot = OfflineSimulation(
        with_lower_limit(urdf, -2.6), **posed(-1.4, "look_front"), **IN_THE_AIR
    )
    try:
        tested = Flippers(robot)
        for names in ORDERS[order]:
            tested.send(-math.pi, names)
            tested.run(2.2, tested.note_contacts)
        sides = {
            frozenset((f"front_{side}_flipper_link", f"rear_{side}_flipper_link"))
            for side in ("left", "right")
        }
        assert set(tested.depth) == sides
        # The belts' own softness, one behind the other, under what a drive presses with on the
        # middle of a flipper.
        softness = 2.0 / robot.simulation.config.tracks.contact_stiffness
        assert max(tested.depth.values()) < softness * DRIVE / MIDDLE
        assert tested.fastest < OVERSPEED
        angles = {name: state.position for name, state in tested.states.items()}
        for side in ("left", "right"):
            # one of them at least stands far off its stop, behind the other
            assert max(angles[f"front_{side}"], angles[f"rear_{side}"]) > -2.1
    finally:
        robot.simulation.close()
