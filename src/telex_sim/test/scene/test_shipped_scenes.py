"""The shipped scenes: nothing stands in anything else, nothing moves by itself, the robot fits."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pybullet
import pytest

from telex_control.common.file_catalog import package_file
from telex_sim.scene.files.scene_file import load_scene

pytestmark = pytest.mark.slow

TRAINING = [
    "accelerator_tunnel", "manipulation_bench", "mobility_lane", "source_room", "stairs",
    "training_hall",
]  # fmt: skip
ALL = ["floor", "load_test", *TRAINING]

PASSES_THROUGH = {
    # What runs along the whole tunnel goes through the wall across it.
    ("line", "sector_wall"), ("sector_wall", "tray_7"),
    # Walls end in the tunnel's, which is curved; the chamber's stands in the niche.
    ("sector_wall", "tunnel"), ("chamber_wall", "tunnel"), ("chamber_door", "tunnel"),
    # The slab of a ramp reaches some millimetres behind its upper edge.
    ("ramp_top", "ramp_up"),
    ("ramp_down", "ramp_top"),
    # Elements of the beam line meet at their flanges.
    ("line", "line"),
}  # fmt: skip


def shipped(name):
    return load_scene(package_file("telex_sim", "scenes", f"{name}.yaml"))


def test_these_scenes_are_shipped():
    folder = package_file("telex_sim", "scenes")
    assert sorted(path.stem for path in folder.glob("*.yaml")) == sorted(ALL)


@pytest.mark.parametrize("name", ALL)
def test_a_scene_says_what_it_is_and_from_where_it_is_seen(name):
    scene = shipped(name)
    assert scene.name == name
    assert scene.description.endswith(".")
    assert len(scene.views) >= (2 if name in TRAINING else 1)


@pytest.mark.parametrize("name", TRAINING)
def test_the_robot_begins_in_front_of_what_it_is_to_train_on(name):
    scene = shipped(name)
    start = scene.start
    ahead = 0
    for item in scene.objects:
        x, y = item.position[0] - start.x, item.position[1] - start.y
        angle = math.remainder(math.atan2(y, x) - start.yaw, 2.0 * math.pi)
        ahead += math.hypot(x, y) < 9.0 and abs(angle) < math.radians(60.0)
    assert ahead >= 5


def test_the_load_is_that_of_the_requirement():
    objects = shipped("load_test").objects
    assert sum(item.model.static for item in objects) == 100
    assert sum(not item.model.static for item in objects) == 30


@pytest.mark.parametrize("name", [name for name in ALL if name != "floor"])
def test_nothing_stands_in_anything_else(stage, name):
    scene = shipped(name)
    made = stage(*scene.objects, floor=scene.floor)
    made.world.step()
    bodies = {item.name: made.objects.bodies_of(item.name) for item in scene.objects}
    entries = {item.name: item.entry for item in scene.objects}
    deep = set()
    for one, other in itertools.combinations(scene.objects, 2):
        pair = tuple(sorted((entries[one.name], entries[other.name])))
        if pair in PASSES_THROUGH:
            continue
        for a, b in itertools.product(bodies[one.name], bodies[other.name]):
            # Only where the bounding boxes meet is it worth while to look closer.
            (low_a, high_a), (low_b, high_b) = (
                pybullet.getAABB(uid, physicsClientId=made.client) for uid in (a, b)
            )
            if any(low_a[i] > high_b[i] or low_b[i] > high_a[i] for i in range(3)):
                continue
            points = pybullet.getClosestPoints(a, b, 0.0, physicsClientId=made.client)
            if any(point[8] < -2e-3 for point in points):
                deep.add((one.name, other.name))
    assert deep == set()


@pytest.mark.parametrize("name", [name for name in ALL if name != "floor"])
def test_nothing_moves_by_itself(stage, name):
    scene = shipped(name)
    made = stage(*scene.objects, floor=scene.floor)
    frames = made.objects.frames()

    def places():
        return np.array(made.objects.poses()).reshape(-1, 7)

    before = places()
    made.run(2.9)
    late = places()
    made.run(0.1)
    after = places()
    moved = np.linalg.norm((after - before)[:, :3], axis=1)
    speed = np.linalg.norm((after - late)[:, :3], axis=1) / 0.1
    turned = 1.0 - np.abs(np.sum(before[:, 3:] * after[:, 3:], axis=1))
    restless = [
        frame
        for frame, far, fast, tilt in zip(frames, moved, speed, turned)
        if far > 5e-3 or fast > 1e-3 or tilt > 1e-4
    ]
    assert restless == []


@pytest.mark.parametrize("name", ALL)
def test_the_robot_stands_free_at_the_start(robot, name):
    simulation = robot(world=name).simulation
    for _ in range(250):
        simulation.step()
    client, uid = simulation.world.client, simulation.body.uid
    ground = 0  # the floor is the first body of every world
    touched = {contact[2] for contact in pybullet.getContactPoints(uid, physicsClientId=client)}
    assert touched - {uid} == {ground}
    # It can turn on the spot: nothing stands within the reach of its stretched flippers.
    start = simulation.scene.start
    for step in range(24):
        angle = 2.0 * math.pi * step / 24
        for height in (0.05, 0.25, 0.5):
            eye = (start.x + 2.0 * math.cos(angle), start.y + 2.0 * math.sin(angle), height)
            hit = pybullet.rayTest(eye, (start.x, start.y, height), physicsClientId=client)[0]
            if hit[0] not in (-1, uid):
                away = math.hypot(hit[3][0] - start.x, hit[3][1] - start.y)
                assert away > 0.85
