"""The traction law on a block with one belt: a box link under a heavy box."""

from __future__ import annotations

import math

import pybullet
import pytest

from telex_sim.config import TrackConfig
from telex_sim.scene.bodies import SceneBodies
from telex_sim.scene.model import Floor
from telex_sim.traction import Traction
from telex_sim.world import GRAVITY, World

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
STEP = 0.002
MU, LATERAL = 0.8, 0.6


@pytest.fixture
def world():
    made = World(STEP, 50)
    SceneBodies(made.client, STEP).load(Floor(), (), lambda done, count: None)
    yield made
    made.close()


class Sledge:
    def __init__(self, world, height=0.0501, yaw=0.0):
        self.world = world
        self.body = world.load_robot(URDF, str, (0.0, 0.0, height), yaw, {})
        config = TrackConfig(belts={"belt": 0.1}, friction=MU, lateral_friction=LATERAL)
        self.traction = Traction(self.body, config, STEP)

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
        for _ in range(round(seconds / STEP)):
            self.traction.apply([belt])
            self.world.step()
            if watch is not None:
                watch(self)

    @property
    def place(self):
        return self.body.base_pose()[0]

    @property
    def velocity(self):
        return pybullet.getBaseVelocity(self.body.uid, physicsClientId=self.world.client)[0]


@pytest.mark.parametrize("speed", [0.5, -0.3])
def test_the_robot_runs_at_belt_speed(world, speed):
    sledge = Sledge(world)
    sledge.run(1.0, belt=speed)
    assert sledge.velocity[0] == pytest.approx(speed, rel=1e-3)
    assert abs(sledge.velocity[1]) < 2e-3


def test_forward_follows_the_heading(world):
    sledge = Sledge(world, yaw=math.pi / 2.0)
    sledge.run(1.0, belt=0.5)
    assert sledge.velocity[1] == pytest.approx(0.5, rel=1e-3)
    assert abs(sledge.velocity[0]) < 2e-3


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

    def spy(uid, link, force, point, frame, **options):
        applied.append(force)
        original(uid, link, force, point, frame, **options)

    monkeypatch.setattr(pybullet, "applyExternalForce", spy)
    heading = [0.3]
    worst = []

    def watch(tested):
        # forces of this step against the loads of the contacts that they were computed from
        cosine, sine = math.cos(heading[0]), math.sin(heading[0])
        along = sum(f[0] * cosine + f[1] * sine for f in applied)
        across = sum(f[1] * cosine - f[0] * sine for f in applied)
        if loads[0] > 0.0:
            worst.append(math.hypot(along / (MU * loads[0]), across / (LATERAL * loads[0])))
        applied.clear()
        contacts = pybullet.getContactPoints(tested.body.uid, physicsClientId=world.client)
        loads[0] = sum(contact[9] for contact in contacts)
        heading[0] = pybullet.getEulerFromQuaternion(tested.body.base_pose()[1])[2]

    loads = [0.0]
    sledge.run(0.5, watch=watch)
    sledge.run(1.0, belt=3.0, tilt=(0.0, 0.4), watch=watch)
    assert max(worst) <= 1.0 + 1e-4
    assert max(worst) > 0.99  # it did slip


def test_no_force_in_the_air(world):
    sledge = Sledge(world, height=5.0)
    sledge.run(0.2, belt=2.0)
    assert sledge.velocity[0] == 0.0


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
