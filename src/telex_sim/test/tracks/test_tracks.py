"""Tracks in PyBullet, on a block with one belt: a box link under a heavy box."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
import pybullet
import pytest

from telex_control.common.params import ConfigError
from telex_control.hardware.hardware_interface import VelocityJointInterface
from telex_control.hardware.joint_limits import JointLimits
from telex_control.urdf.joints import joints, parse_urdf
from telex_sim.engine.simulator_config import TrackConfig
from telex_sim.engine.world import GRAVITY, World
from telex_sim.robot.drives import JointDrive
from telex_sim.scene.model import Floor
from telex_sim.scene.objects.bodies import SceneBodies
from telex_sim.stability.footholds import FootholdFinder
from telex_sim.tracks.belt_drive import BeltDriveConfig
from telex_sim.tracks.track_config import Grip
from telex_sim.tracks.tracks import Tracks

MASS = 20.0
URDF = f"""
<robot name="sledge">
  <link name="base"><inertial><mass value="{MASS - 2.0}"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="track"><inertial><mass value="1"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="0.6 0.4 0.1"/></geometry></collision></link>
  <link name="wheel"><inertial><mass value="1"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="mount" type="fixed"><parent link="base"/><child link="track"/></joint>
  <joint name="belt" type="continuous"><parent link="track"/><child link="wheel"/>
    <axis xyz="0 1 0"/></joint>
</robot>
"""
ON_ROOT = f"""
<robot name="monotrack">
  <link name="base"><inertial><mass value="{MASS - 1.0}"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="0.6 0.4 0.1"/></geometry></collision></link>
  <link name="wheel"><inertial><mass value="1"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="belt" type="continuous"><parent link="base"/><child link="wheel"/>
    <axis xyz="0 1 0"/></joint>
</robot>
"""
STEP = 0.002
MU, LATERAL = 0.8, 0.6


@pytest.fixture
def world():
    made = World(STEP, 50)
    SceneBodies(made.client, STEP).load(Floor(), (), lambda done, count: None)
    yield made
    made.close()


FIRM = BeltDriveConfig(force=1e4, power=1e5, acceleration=1e3, inertia=1.0, brake_force=1e4)
"""A drive that makes of the belt what is commanded."""
RIGID = {"contact_stiffness": 1.0e6, "contact_damping": 6.0e4}
"""A box has no single lowest point: if it gave way, it would nod from corner to corner."""
RADIUS = 0.1


class Sledge:
    def __init__(self, world, height=0.0501, yaw=0.0, urdf=URDF, material_of=None, **config):
        self.world = world
        self.body = world.load_robot(urdf, str, (0.0, 0.0, height), yaw, {})
        description = joints(parse_urdf(URDF))["belt"]
        limits = JointLimits(max_velocity=100.0, max_effort=1e3)
        self.drive = JointDrive(description, VelocityJointInterface, limits, None, 1.0)
        self.drive.index = self.body.joints["belt"]
        self.drive.braked = False
        config = {"friction": MU, "lateral_friction": LATERAL, "drive": FIRM, **RIGID, **config}
        config = TrackConfig(belts={"belt": RADIUS}, **config)
        self.tracks = Tracks(self.body, config, {"belt": self.drive}, STEP, material_of)

    def run(self, seconds, belt=0.0, tilt=(0.0, 0.0), watch=None):
        """Let gravity pull along (x, y) as on a slope of these angles (rad)."""
        along, across = tilt
        angle = math.hypot(along, across)
        pull = GRAVITY * math.sin(angle)
        share = (along / angle, across / angle) if angle else (0.0, 0.0)
        pybullet.setGravity(
            pull * share[0],
            pull * share[1],
            -GRAVITY * math.cos(angle),
            physicsClientId=self.world.client,
        )
        self.drive.handle.command = belt / RADIUS
        for _ in range(round(seconds / STEP)):
            self.tracks.step()
            self.world.step()
            if watch is not None:
                watch(self)

    @property
    def place(self):
        return self.body.base_pose()[0]

    @property
    def velocity(self):
        return pybullet.getBaseVelocity(self.body.uid, physicsClientId=self.world.client)[0]


@pytest.mark.parametrize(("speed", "urdf"), [(0.5, URDF), (-0.3, URDF), (0.5, ON_ROOT)])
def test_the_robot_runs_at_belt_speed(world, speed, urdf):
    sledge = Sledge(world, urdf=urdf)
    sledge.run(0.5, belt=speed)
    start = sledge.place
    sledge.run(0.5, belt=speed)
    assert sledge.place[0] - start[0] == pytest.approx(0.5 * speed, rel=1e-3)
    assert abs(sledge.place[1] - start[1]) < 1e-3


@pytest.mark.parametrize(
    ("material_of", "told"), [(None, "solid"), (lambda uid, link: "gravel", "gravel")]
)
def test_it_tells_what_its_belts_run_on(world, material_of, told):
    sledge = Sledge(world, height=0.06, material_of=material_of)
    sledge.run(STEP)
    assert sledge.tracks.surface() == ""
    sledge.run(0.2)
    assert sledge.tracks.surface() == told


def test_forward_follows_the_heading(world):
    sledge = Sledge(world, yaw=math.pi / 2.0)
    sledge.run(0.5, belt=0.5)
    start = sledge.place
    sledge.run(0.5, belt=0.5)
    assert sledge.place[1] - start[1] == pytest.approx(0.25, rel=1e-3)
    assert abs(sledge.place[0] - start[0]) < 1e-3


def test_a_stuck_track_stands_still_on_a_slope(world):
    sledge = Sledge(world)
    sledge.run(0.5, tilt=(0.5, 0.0))
    before = sledge.place
    sledge.run(5.0, tilt=(0.5, 0.0))
    assert math.dist(before, sledge.place) < 1e-4


@pytest.mark.parametrize(
    ("mu", "direction"), [(MU, (1.0, 0.0)), (MU, (-1.0, 0.0)), (LATERAL, (0.0, 1.0))]
)
def test_it_slips_at_the_friction_angle(world, mu, direction):
    limit = math.atan(mu)
    for angle, slips in ((limit - 0.02, False), (limit + 0.02, True)):
        sledge = Sledge(world)
        sledge.run(2.0, tilt=(direction[0] * angle, direction[1] * angle))
        moved = math.hypot(sledge.place[0], sledge.place[1])
        assert (moved > 0.05) is slips, (angle, moved)
        world.clear()


def test_braking_force_is_that_of_coulomb(world):
    sledge = Sledge(world)
    sledge.run(1.0, belt=1.0)
    start = sledge.place[0]
    sledge.run(1.0, belt=0.0)
    assert sledge.place[0] - start == pytest.approx(1.0 / (2.0 * MU * GRAVITY), rel=0.1)


def test_force_never_exceeds_the_friction_ellipse(world, monkeypatch):
    sledge = Sledge(world, yaw=0.3)
    applied = []
    original = pybullet.applyExternalForce

    def spy(uid, link, force, *rest):
        applied.append(force)
        original(uid, link, force, *rest)

    monkeypatch.setattr(pybullet, "applyExternalForce", spy)
    heading = [0.3]
    worst = []

    def watch(tested):
        # forces of this step against the loads of the contacts that they were computed from
        cosine, sine = math.cos(heading[0]), math.sin(heading[0])
        along = sum(f[0] * cosine + f[1] * sine for f in applied)
        across = sum(f[1] * cosine - f[0] * sine for f in applied)
        # It goes by the load's mean over a few steps, which one that falls at once leaves above it.
        load = min(max(loads), 2.0 * loads[-1])
        if load > 0.0:
            worst.append(math.hypot(along / (MU * load), across / (LATERAL * load)))
        applied.clear()
        contacts = pybullet.getContactPoints(tested.body.uid, physicsClientId=world.client)
        loads.append(sum(contact[9] for contact in contacts))
        heading[0] = pybullet.getEulerFromQuaternion(tested.body.base_pose()[1])[2]

    loads = deque([0.0], maxlen=20)
    sledge.run(0.5, watch=watch)
    sledge.run(1.0, belt=3.0, tilt=(0.0, 0.4), watch=watch)
    assert max(worst) <= 1.0 + 1e-4
    assert max(worst) > 0.99  # it did slip


WINDOW = round(0.020 / STEP)


@pytest.mark.parametrize(
    ("height", "yaw", "plan"),
    [
        (0.0501, 0.0, [(0.5, 1.0, (0.0, 0.0)), (0.5, 0.0, (0.0, 0.0))]),
        (0.0501, 0.3, [(1.0, 3.0, (0.0, 0.4))]),
        (0.0501, 0.0, [(1.0, -2.0, (0.5, 0.3))]),
        (0.3, 0.0, [(0.8, 2.0, (0.0, 0.0))]),
    ],
    ids=["braking", "across", "spinning uphill", "dropped"],
)
def test_impulse_stays_in_the_cone_over_20_ms(world, monkeypatch, height, yaw, plan):
    """Loads come as impulses, of 65 and 1300 N in turn when it slides; friction spreads them."""
    sledge = Sledge(world, height=height, yaw=yaw)
    applied, frictions, loads = [], [], [0.0]
    original = pybullet.applyExternalForce

    def spy(uid, link, force, *rest):
        applied.append(force)
        original(uid, link, force, *rest)

    monkeypatch.setattr(pybullet, "applyExternalForce", spy)
    heading = yaw

    def watch(tested):
        nonlocal heading
        cosine, sine = math.cos(heading), math.sin(heading)
        along = sum(f[0] * cosine + f[1] * sine for f in applied)
        across = sum(f[1] * cosine - f[0] * sine for f in applied)
        frictions.append((along / MU, across / LATERAL))
        applied.clear()
        contacts = pybullet.getContactPoints(tested.body.uid, physicsClientId=world.client)
        loads.append(sum(contact[9] for contact in contacts))
        heading = pybullet.getEulerFromQuaternion(tested.body.base_pose()[1])[2]

    for seconds, belt, tilt in plan:
        sledge.run(seconds, belt=belt, tilt=tilt, watch=watch)
    used = 0.0
    for begin in range(len(frictions) - WINDOW):
        end = begin + WINDOW
        friction = math.hypot(*(sum(part) for part in zip(*frictions[begin:end])))
        # `loads` runs a step ahead: these are what the frictions were computed from. Beyond their
        # sum is one step of the mean that was left from before, or of the first touch.
        pressed = sum(loads[begin:end]) + max(loads[max(0, begin - WINDOW) : end])
        assert friction <= pressed * (1.0 + 1e-6), begin
        used = max(used, friction / pressed if pressed else 0.0)
    assert used > 0.85  # a steady slip comes to 10 / 11


def test_no_force_in_the_air(world):
    sledge = Sledge(world, height=5.0)
    sledge.run(0.2, belt=2.0)
    assert abs(sledge.velocity[0]) < 1e-12


def test_a_loose_object_takes_the_reaction(world):
    shape = pybullet.createCollisionShape(
        pybullet.GEOM_BOX, halfExtents=(1.0, 1.0, 0.05), physicsClientId=world.client
    )
    board = pybullet.createMultiBody(
        10.0, shape, basePosition=(0.0, 0.0, 0.05), physicsClientId=world.client
    )
    # a board that slides freely: what drives the sledge forward drives it back
    pybullet.changeDynamics(board, -1, lateralFriction=1.0, physicsClientId=world.client)
    pybullet.changeDynamics(0, -1, lateralFriction=0.0, physicsClientId=world.client)
    sledge = Sledge(world, height=0.1501)
    sledge.run(0.3, belt=0.0)
    sledge.run(0.2, belt=0.5)
    back = pybullet.getBaseVelocity(board, physicsClientId=world.client)[0][0]
    assert sledge.velocity[0] > 0.1
    assert MASS * sledge.velocity[0] + 10.0 * back == pytest.approx(0.0, abs=0.2)
    assert sledge.velocity[0] - back == pytest.approx(0.5, rel=0.02)


def test_momentum_is_conserved_with_a_loose_body(world):
    """A sledge drives off its middle over a board on ice: both turn, their sum does not."""
    client = world.client
    pybullet.changeDynamics(0, -1, lateralFriction=0.0, physicsClientId=client)
    shape = pybullet.createCollisionShape(
        pybullet.GEOM_BOX, halfExtents=(1.5, 1.5, 0.05), physicsClientId=client
    )
    board = pybullet.createMultiBody(
        30.0, shape, basePosition=(0.1, 0.25, 0.05), physicsClientId=client
    )
    pybullet.changeDynamics(
        board, -1, linearDamping=0.0, angularDamping=0.0, physicsClientId=client
    )
    sledge = Sledge(world, height=0.1501, yaw=0.4)
    bodies = [sledge.body.uid, board]

    def momentum():
        total = [0.0, 0.0, 0.0]
        for uid in bodies:
            for link in range(-1, pybullet.getNumJoints(uid, physicsClientId=client)):
                info = pybullet.getDynamicsInfo(uid, link, physicsClientId=client)
                mass, spin = info[0], info[2][2]
                if link < 0:
                    centre = pybullet.getBasePositionAndOrientation(uid, physicsClientId=client)[0]
                    linear, angular = pybullet.getBaseVelocity(uid, physicsClientId=client)
                else:
                    state = pybullet.getLinkState(uid, link, 1, 1, physicsClientId=client)
                    centre, linear, angular = state[0], state[6], state[7]
                total[0] += mass * linear[0]
                total[1] += mass * linear[1]
                total[2] += mass * (centre[0] * linear[1] - centre[1] * linear[0])
                total[2] += spin * angular[2]
        return total

    sledge.run(0.3)
    before = momentum()
    sledge.run(0.6, belt=0.8)
    moved = pybullet.getBaseVelocity(board, physicsClientId=client)
    assert math.hypot(*moved[0][:2]) > 0.1
    assert abs(moved[1][2]) > 0.02
    assert momentum() == pytest.approx(before, abs=0.02)


def test_a_light_block_on_a_standing_track_lies_still(world):
    client = world.client
    sledge = Sledge(world)
    shape = pybullet.createCollisionShape(
        pybullet.GEOM_BOX, halfExtents=(0.03, 0.03, 0.03), physicsClientId=client
    )
    block = pybullet.createMultiBody(
        0.05, shape, basePosition=(0.1, 0.05, 0.1302), physicsClientId=client
    )
    pybullet.changeDynamics(block, -1, lateralFriction=1.0, physicsClientId=client)
    sledge.run(1.0)
    speeds = []

    def watch(tested):
        linear, angular = pybullet.getBaseVelocity(block, physicsClientId=client)
        speeds.append(math.hypot(*linear) + 0.03 * math.hypot(*angular))

    sledge.run(0.5, watch=watch)
    assert max(speeds) < 2e-3
    # On ice the sledge stays; the block rides along with the belt's upper run, which goes forward.
    pybullet.changeDynamics(0, -1, lateralFriction=0.0, physicsClientId=client)
    sledge.tracks.forget_surfaces()
    before = pybullet.getBasePositionAndOrientation(block, physicsClientId=client)[0][0]
    sledge.run(0.5, belt=0.2)
    after = pybullet.getBasePositionAndOrientation(block, physicsClientId=client)[0][0]
    assert after - before == pytest.approx(0.1, rel=0.02)


@pytest.mark.parametrize("yaw", [0.0, 0.9, 2.5])
def test_the_heading_in_the_world_does_not_matter(world, yaw):
    """Driving and slipping, seen from the sledge."""
    sledge = Sledge(world, yaw=yaw)
    sledge.run(0.3)
    sledge.run(0.5, belt=0.6)
    sledge.run(0.5, belt=-0.4)
    x, y, _ = sledge.place
    decelerated = [0.6 / (MU * GRAVITY), 1.0 / (MU * GRAVITY)]
    expected = 0.6 * (0.5 - 0.5 * decelerated[0])
    expected += 0.5 * (0.6 - 0.4) * decelerated[1] - 0.4 * (0.5 - decelerated[1])
    forward = x * math.cos(yaw) + y * math.sin(yaw)
    sideways = y * math.cos(yaw) - x * math.sin(yaw)
    assert forward == pytest.approx(expected, abs=3e-3)
    assert abs(sideways) < 2e-3


def test_the_load_shows_as_effort_and_inertia_counts(world):
    config = BeltDriveConfig(
        force=300.0, power=1e4, acceleration=2.0, inertia=15.0, brake_force=500.0
    )
    sledge = Sledge(world, drive=config)
    sledge.run(0.3)
    sledge.run(0.2, belt=1.0)
    state = sledge.drive.state
    assert state.velocity * RADIUS == pytest.approx(0.4, rel=1e-3)
    assert sledge.velocity[0] == pytest.approx(0.4, rel=0.02)
    # the sledge and the belt, at 2 m/s2
    assert state.effort / RADIUS == pytest.approx((MASS + 15.0) * 2.0, rel=0.05)
    assert state.position == pytest.approx(0.5 * 2.0 * 0.2**2 / RADIUS, rel=0.02)
    wheel = pybullet.getJointState(
        sledge.body.uid, sledge.drive.index, physicsClientId=world.client
    )
    assert wheel[1] == pytest.approx(state.velocity, rel=1e-3)


def test_a_belt_without_power_for_the_slope_stalls_and_slides_back(world):
    config = BeltDriveConfig(force=60.0, power=250.0)
    sledge = Sledge(world, drive=config)
    sledge.run(0.5)
    sledge.run(1.0, belt=0.5, tilt=(-0.2, 0.0))
    # 39 N of 60 N: it climbs
    assert sledge.velocity[0] == pytest.approx(0.5, rel=0.01)
    sledge.run(2.0, belt=0.5, tilt=(-0.4, 0.0))
    # 76 N: it is pushed back, with the belt under it and not over a slipping one
    assert sledge.velocity[0] < -0.3
    assert sledge.drive.state.velocity * RADIUS == pytest.approx(sledge.velocity[0], rel=0.01)
    assert sledge.drive.state.effort == pytest.approx(60.0 * RADIUS)


def test_the_brake_holds_where_the_motor_does_not(world):
    sledge = Sledge(world, drive=BeltDriveConfig(force=60.0, brake_force=200.0))
    sledge.drive.braked = True
    sledge.run(1.0, tilt=(0.5, 0.0))
    before = sledge.place
    sledge.run(2.0, belt=1.0, tilt=(0.5, 0.0))
    assert math.dist(before, sledge.place) < 1e-4
    assert sledge.drive.state.velocity == 0.0
    assert sledge.drive.state.effort / RADIUS == pytest.approx(
        -MASS * GRAVITY * math.sin(0.5), rel=0.01
    )


def test_flanks_rub_and_do_not_drive(world):
    """A sledge between two walls, its weight on ice: the walls' friction is that of the flanks."""
    client = world.client
    pybullet.changeDynamics(0, -1, lateralFriction=0.0, physicsClientId=client)
    shape = pybullet.createCollisionShape(
        pybullet.GEOM_BOX, halfExtents=(5.0, 0.1, 0.5), physicsClientId=client
    )
    wall = pybullet.createMultiBody(
        0.0, shape, basePosition=(0.0, 0.3005, 0.5), physicsClientId=client
    )
    pybullet.changeDynamics(wall, -1, lateralFriction=1.0, physicsClientId=client)
    sledge = Sledge(world, side_friction=0.3)
    pull = 0.4
    sledge.run(0.5, belt=3.0, tilt=(0.0, pull))
    assert abs(sledge.velocity[0]) < 1e-3
    pybullet.resetBaseVelocity(sledge.body.uid, (1.0, 0.0, 0.0), physicsClientId=client)
    start = sledge.place[0]
    sledge.run(2.0, belt=3.0, tilt=(0.0, pull))
    stopping = 1.0 / (2.0 * 0.3 * GRAVITY * math.sin(pull))
    assert sledge.place[0] - start == pytest.approx(stopping, rel=0.1)


@pytest.mark.parametrize("grip", [(MU, 5e-324), (5e-324, LATERAL), (1e-310, 1e-310)])
def test_where_the_grip_is_too_little_to_reckon_with_there_is_none(world, grip):
    materials = {"ice": Grip(*grip)}
    pybullet.changeDynamics(0, -1, lateralFriction=0.5, physicsClientId=world.client)
    sledge = Sledge(world, material_of=lambda uid, link: "ice", materials=materials)
    sledge.run(0.5, belt=0.5, tilt=(0.2, 0.0))
    assert sledge.velocity[0] == pytest.approx(0.5 * GRAVITY * math.sin(0.2), rel=0.05)


@pytest.mark.parametrize("grip", [1.0, 1.5])
def test_cleats_catch_edges(world, grip):
    """On the edge of a box the belt pulls harder than on its face."""
    client = world.client
    pybullet.changeDynamics(0, -1, lateralFriction=0.0, physicsClientId=client)
    half = 0.2
    shape = pybullet.createCollisionShape(
        pybullet.GEOM_BOX, halfExtents=(half, 2.0, half), physicsClientId=client
    )
    centre = -half * math.sqrt(2.0)
    pybullet.createMultiBody(
        0.0,
        shape,
        basePosition=(0.0, 0.0, centre + 0.3),
        baseOrientation=pybullet.getQuaternionFromEuler((0.0, math.pi / 4.0, 0.0)),
        physicsClientId=client,
    )
    pybullet.changeDynamics(1, -1, lateralFriction=1.0, physicsClientId=client)
    sledge = Sledge(world, height=0.3501, edge_grip=grip)
    pulled = []

    def watch(tested):
        pulled.append(tested.drive.state.effort / RADIUS)
        contacts = pybullet.getContactPoints(tested.body.uid, physicsClientId=client)
        loads.append(sum(contact[9] for contact in contacts))

    loads = []
    sledge.run(0.05)
    sledge.run(0.05, belt=3.0, watch=watch)
    # The force of a slipping belt, which accelerates nothing any more. It goes by the load's mean,
    # and of one that rises steadily this is the load of a step before that of the last step.
    assert pulled[-1] / loads[-3] == pytest.approx(MU * grip, rel=1e-3)


def test_drives_share_a_shaft():
    config = TrackConfig(belts={"a": 0.1, "b": 0.1, "c": 0.1}, drives={"left": ("a", "b")})
    assert config.groups() == [("a", "b"), ("c",)]


@pytest.mark.parametrize(
    ("drives", "named"),
    [
        ({"left": ()}, "drives/left is"),
        ({"left": ("a", "x")}, "drives/left: 'x' is not one of belts; there are: a, b"),
        ({"left": ("a",), "right": ("a",)}, "drives/right: 'a' is in drives/left already"),
    ],
)
def test_wrong_drives_are_named(drives, named):
    with pytest.raises(ConfigError) as caught:
        TrackConfig(belts={"a": 0.1, "b": 0.1}, drives=drives)
    assert named in str(caught.value)


def test_a_belt_around_the_root_link_has_footholds(world):
    sledge = Sledge(world, urdf=ON_ROOT)
    sledge.run(0.2)
    centers, axles = {-1: np.array(sledge.place)}, {-1: np.array((0.0, 1.0, 0.0))}
    places, *_ = FootholdFinder(sledge.body, {-1: (-0.2, 0.2)}).touching(centers, axles)
    assert {round(y, 2) for y in places[:, 1]} == {-0.2, 0.2}
