"""Another scene comes into the place of the present one while the simulation runs."""

from __future__ import annotations

import gc
import resource
from pathlib import Path

import pybullet
import pytest
from geometry_msgs.msg import Twist

from telex_control.ros.local_node_handle import LocalNodeHandle
from telex_sim.offline.simulation import shipped_config
from telex_sim.scene.catalog import scenes
from telex_sim.scene.files.scene_file import SceneError

pytestmark = pytest.mark.slow

PAGE = resource.getpagesize()
BLOCK = "{{type: platform, name: {name}, length: 0.4, width: 0.4, height: 0.4, position: {at}}}"


@pytest.fixture
def scene(tmp_path):
    """Writes a scene file, and returns its path."""

    def write(name, *entries, head=""):
        path = tmp_path / f"{name}.yaml"
        path.write_text(head + "\nobjects:\n" + "".join(f"  - {entry}\n" for entry in entries))
        return str(path)

    return write


def change(tested, world):
    simulation = tested.simulation
    simulation.change_scene(simulation.plan_scene(world))


def state(tested):
    """All that tells one state from another."""
    simulation = tested.simulation
    client = simulation.world.client
    return (
        simulation.link_poses(),
        simulation.hw.joint_positions(),
        [
            pybullet.getBaseVelocity(uid, physicsClientId=client)
            for uid in simulation.world.bodies()
        ],
    )


def test_each_shipped_scene_after_another_is_as_if_it_had_been_the_first(robot):
    tested = robot(world="floor")
    simulation = tested.simulation
    for name in scenes():
        before = simulation.time
        tested.run(0.02)
        change(tested, name)
        assert simulation.scene.name == name
        assert simulation.scene_path.stem == name
        assert simulation.time == pytest.approx(before + 0.02)
        loaded, objects = simulation.link_poses(), simulation.objects.objects()
        fresh = robot(world=name).simulation
        assert [each.name for each in objects] == [each.name for each in fresh.objects.objects()]
        assert loaded == fresh.link_poses()
        assert simulation.world.bodies() == fresh.world.bodies()
        tested.run(0.02)
        after = state(tested)
        simulation.reset()
        assert simulation.link_poses() == loaded
        tested.run(0.02)
        assert state(tested) == after


def test_controllers_and_robot_are_as_after_a_reset(robot, scene):
    tested = robot(world=scene("first", head="start: {pose: drive}"))
    simulation = tested.simulation
    publisher = tested.node.advertise("track_controller/cmd_vel", Twist)
    message = Twist()
    message.linear.x = 0.8
    for _ in range(10):
        publisher.publish(message)
        tested.run(0.05)
    simulation.spawn(simulation.plan(BLOCK.format(name="late", at=[0.0, 3.0, 0.0])))
    assert simulation.body.base_pose()[0][0] > 0.1
    change(tested, scene("second", head="start: {x: 2.0, y: -1.0, yaw: 1.0, pose: stow}"))
    tested.run(0.5)
    position, orientation = simulation.body.base_pose()
    # The command that was under way is forgotten.
    assert position[:2] == pytest.approx((2.0, -1.0), abs=0.005)
    assert pybullet.getEulerFromQuaternion(orientation)[2] == pytest.approx(1.0, abs=0.01)
    wanted = simulation.config.start.poses["stow"]["shoulder_joint"]
    assert tested.positions()["shoulder_joint"] == pytest.approx(wanted, abs=5e-3)
    assert simulation.objects.frames() == []
    simulation.reset()
    assert simulation.body.base_pose()[0][:2] == pytest.approx((2.0, -1.0), abs=1e-9)


def test_a_scene_that_is_refused_changes_nothing(robot, scene):
    tested = robot(world=scene("first", BLOCK.format(name="near", at=[2.0, 0.0, 0.0])))
    tested.run(0.1)
    before, path = state(tested), tested.simulation.scene_path
    pillar = BLOCK.format(name="pillar", at=[0.3, 0.0, 0.0])
    for entry, head, said in (
        ("{type: unicorn}", "", r"second.yaml: objects\[0\] \(unicorn\): type is 'unicorn'"),
        ("{type: crate, mass: -1}", "", r"second.yaml: objects\[0\] \(crate\): mass is -1"),
        ("{type: crate, name: telex}", "", "second.yaml: objects: name is 'telex'"),
        ("{type: crate, position: [.nan, 0, 0]}", "", r"position\[0\] is nan"),
        ("{type: crate}", "start: {pose: handstand}", "start/pose is 'handstand'; there are: "),
        (pillar, "", r"start pose 'ready': the robot's \w+ stands \d+ mm deep in 'pillar'"),
        ("{", "", "second.yaml: .*no YAML"),
    ):
        with pytest.raises(SceneError, match=said):
            change(tested, scene("second", entry, head=head))
        assert state(tested) == before
        assert tested.simulation.scene_path == Path(path)
    with pytest.raises(SceneError, match="there is no scene 'moon'; there are: .*stairs"):
        change(tested, "moon")
    tested.run(0.1)
    undisturbed = robot(world=str(path))
    undisturbed.run(0.2)
    assert state(tested) == state(undisturbed)


def test_further_robots_need_their_place_too(robot, urdf, scene):
    tested = robot()
    simulation = tested.simulation
    place = [0.0, 4.0, simulation.config.start.height, 0.0]
    config = shipped_config(start__place=place, model="second")
    node = LocalNodeHandle({"robot_description": urdf}, "/second")
    simulation.add_robot(simulation.plan_robot(config, urdf, node))
    wall = BLOCK.format(name="wall", at=[0.0, 4.0, 0.0])
    before = simulation.link_poses()
    with pytest.raises(SceneError, match="robot 'second' would stand in 'wall'; start/place"):
        change(tested, scene("bad", wall))
    assert simulation.link_poses() == before
    change(tested, scene("good", BLOCK.format(name="wall", at=[5.0, 4.0, 0.0])))
    assert [each.model for each in simulation.robots] == ["telex", "second"]
    assert simulation.robots[1].body.base_pose()[0][:2] == pytest.approx((0.0, 4.0), abs=1e-6)


WALL = (
    "{{type: platform, name: {name}, length: {length}, width: {width}, height: 1.0, "
    "position: [{x}, {y}, 0.0]}}"
)


def wall(name, x, y, length=0.1, width=0.1):
    return WALL.format(name=name, x=x, y=y, length=length, width=width)


def add_beside(tested, urdf):
    simulation = tested.simulation
    node = LocalNodeHandle({"robot_description": urdf}, "/second")
    config = shipped_config(model="second", start__beside=True)
    simulation.add_robot(simulation.plan_robot(config, urdf, node))


def where(tested):
    return tested.simulation.robots[1].body.base_pose()[0][:2]


def test_a_further_robot_finds_room_beside_the_start_of_each_scene(robot, urdf, scene):
    tested = robot()
    add_beside(tested, urdf)
    assert where(tested) == pytest.approx((0.0, 1.3), abs=1e-6)
    tested.run(1.0)
    x, y, z = tested.simulation.robots[1].body.base_pose()[0]
    assert (x, y, z) == pytest.approx((0.0, 1.3, 0.11), abs=0.02)
    change(tested, scene("left", BLOCK.format(name="left", at=[0.0, 1.3, 0.0])))
    assert where(tested) == pytest.approx((0.0, -1.3), abs=1e-6)
    # Not behind a wall, though there is room.
    lane = [wall("left", 0.0, 0.8, 4.0), wall("right", 0.0, -0.8, 4.0)]
    change(tested, scene("lane", *lane))
    assert where(tested) == pytest.approx((-1.8, 0.0), abs=1e-6)
    tested.run(0.5)
    tested.simulation.reset()
    assert where(tested) == pytest.approx((-1.8, 0.0), abs=1e-6)


def cell():
    """Walls that leave room for one robot."""
    return [
        *(wall("left", 0.0, 0.8, 3.0), wall("right", 0.0, -0.8, 3.0)),
        *(wall("front", 1.4, 0.0, width=1.4), wall("back", -1.2, 0.0, width=1.4)),
    ]


def test_a_scene_without_room_for_all_robots_is_refused(robot, urdf, scene):
    tested = robot()
    add_beside(tested, urdf)
    before = tested.simulation.link_poses()
    with pytest.raises(SceneError, match="robot 'second' finds no room beside the scene's start"):
        change(tested, scene("cell", *cell()))
    assert tested.simulation.link_poses() == before


def test_a_reset_that_leaves_no_room_puts_a_further_robot_where_there_is_some(
    robot, urdf, scene, caplog
):
    tested = robot(world=scene("cell", *cell()))
    simulation = tested.simulation
    first, objects = simulation.body.base_pose(), simulation.objects.objects()
    for name in ("left", "right", "front", "back"):
        simulation.delete(name)
    add_beside(tested, urdf)
    assert where(tested) == pytest.approx((0.0, 1.3), abs=1e-6)
    simulation.reset()
    assert "robot 'second' finds no room beside the scene's start" in caplog.text
    assert [each.name for each in simulation.objects.objects()] == [each.name for each in objects]
    assert simulation.body.base_pose() == first
    second = simulation.robots[1].body
    assert simulation.world.overlap(second, 0.01) is None
    placed = where(tested)
    tested.run(0.5)
    assert where(tested) == pytest.approx(placed, abs=0.02)
    simulation.reset()
    assert where(tested) == placed
    assert simulation.body.base_pose() == first


def test_a_reset_leaves_robots_apart_where_one_was_added_at_the_start_of_another(
    robot, urdf, caplog
):
    tested = robot()
    simulation = tested.simulation
    pybullet.resetBasePositionAndOrientation(
        simulation.body.uid, (5.0, 0.0, 0.12), (0, 0, 0, 1), simulation.world.client
    )
    place = [0.0, 0.0, simulation.config.start.height, 0.0]
    config = shipped_config(model="second", start__place=place)
    node = LocalNodeHandle({"robot_description": urdf}, "/second")
    simulation.add_robot(simulation.plan_robot(config, urdf, node))
    simulation.reset()
    assert "robot 'second' would stand in robot 'telex'" in caplog.text
    assert simulation.body.base_pose()[0][:2] == pytest.approx((0.0, 0.0), abs=1e-6)
    assert where(tested) == pytest.approx((0.0, 1.3), abs=1e-6)


def resident():
    gc.collect()
    return int(Path("/proc/self/statm").read_text().split()[1]) * PAGE / 1e6


def test_memory_does_not_grow_with_changes(robot):
    tested = robot()
    names = ("stairs", "training_hall")
    for name in names * 2:
        change(tested, name)
    before = resident()
    for name in names * 6:
        change(tested, name)
        tested.run(0.01)
    grown = resident() - before
    assert grown < 4.0, f"{grown:.1f} MB"
