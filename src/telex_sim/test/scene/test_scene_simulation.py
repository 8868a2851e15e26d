"""The robot in scenes: where it starts, what it pushes, what comes and goes."""

from __future__ import annotations

import math
import threading

import pybullet
import pytest
from geometry_msgs.msg import Twist

from telex_control.common.params import ConfigError
from telex_sim.engine.bookmarks import Bookmarks
from telex_sim.scene.files.scene_file import SceneError

pytestmark = pytest.mark.slow

BLOCK = "{{type: custom, name: {name}, position: {at}, links: [{{name: body, mass: {mass},\
 friction: {friction}, parts: [{{box: {size}, position: [0, 0, {half}]}}]}}]}}"


def block(name, at, size=(0.3, 0.3, 0.3), mass=4.0, friction=1.0):
    return BLOCK.format(
        name=name, at=list(at), size=list(size), half=size[2] / 2.0, mass=mass, friction=friction
    )


@pytest.fixture
def scene(tmp_path):
    """Writes a scene file, and returns its path."""

    def write(*entries, head=""):
        path = tmp_path / "yard.yaml"
        path.write_text(head + "\nobjects:\n" + "".join(f"  - {entry}\n" for entry in entries))
        return str(path)

    return write


def drive(robot, speed, seconds):
    publisher = robot.node.advertise("track_controller/cmd_vel", Twist)
    message = Twist()
    message.linear.x = speed
    for _ in range(round(seconds / 0.05)):
        publisher.publish(message)
        robot.run(0.05)


def place(robot, frame=None):
    simulation = robot.simulation
    if frame is None:
        return simulation.body.base_pose()[0]
    index = simulation.objects.frames().index(frame)
    return tuple(simulation.objects.poses()[7 * index : 7 * index + 3])


def test_the_robot_starts_where_the_scene_says(robot, scene):
    step = block("stage", (3.0, 1.0, 0.0), (2.0, 2.0, 0.4), mass=0.0).replace(
        "links", "static: true, links"
    )
    head = "start: {x: 3.0, y: 1.0, ground: 0.4, yaw: 1.2, pose: drive}"
    tested = robot(world=scene(step, head=head))
    tested.run(1.0)
    position, orientation = tested.simulation.body.base_pose()
    assert position == pytest.approx((3.0, 1.0, 0.51), abs=0.01)
    assert pybullet.getEulerFromQuaternion(orientation)[2] == pytest.approx(1.2, abs=0.01)
    wanted = tested.simulation.config.start.poses["drive"]["shoulder_joint"]
    assert tested.positions()["shoulder_joint"] == pytest.approx(wanted, abs=5e-3)


def test_a_pose_that_is_asked_for_overrides_the_scenes(robot, scene):
    tested = robot(world=scene(head="start: {pose: drive}"), start__pose="stow")
    wanted = tested.simulation.config.start.poses["stow"]["shoulder_joint"]
    assert tested.positions()["shoulder_joint"] == pytest.approx(wanted, abs=1e-6)


def test_mistakes_of_a_scene_end_the_start(robot, scene):
    with pytest.raises(SceneError, match=r"yard.yaml: start/pose is 'handstand'; there are: "):
        robot(world=scene(head="start: {pose: handstand}"))
    with pytest.raises(SceneError, match=r"yard.yaml: objects\[0\] \(custom 'a'\): .*mass is -1"):
        robot(world=scene(block("a", (1, 0, 0), mass=-1.0)))
    with pytest.raises(SceneError, match="name is 'telex'; it is that of another frame"):
        robot(world=scene(block("telex", (1, 0, 0))))
    with pytest.raises(SceneError, match="there is no scene 'moon'; there are: "):
        robot(world="moon")


def test_the_robot_pushes_what_sleeps(robot, scene):
    tested = robot(world=scene(block("box", (1.2, 0.0, 0.0), friction=0.5)), start__pose="drive")
    tested.run(4.0)
    assert place(tested, "box/body") == pytest.approx((1.2, 0.0, 0.0), abs=1e-3)
    drive(tested, 0.5, 3.0)
    assert place(tested, "box/body")[0] > 1.4


def test_tracks_kick_a_pallet_that_sleeps_under_them(robot, scene):
    pallet = block("pallet", (0.0, 0.0, 0.0), (2.0, 1.2, 0.1), 20.0, friction=1.0)
    head = "floor: {friction: 0.05}\nstart: {ground: 0.1, pose: drive}"
    tested = robot(world=scene(pallet, head=head))
    tested.run(4.0)
    rests = place(tested, "pallet/body")
    assert rests == pytest.approx((0.0, 0.0, 0.0), abs=5e-3)
    drive(tested, 0.6, 0.5)
    # Momentum: the robot goes one way, the pallet, nearly on ice, the other.
    assert place(tested, "pallet/body")[0] < rests[0] - 0.05
    assert place(tested)[0] > 0.02


def test_spawned_objects_are_there_and_carry_the_robot(robot):
    tested = robot(start__pose="drive")
    simulation = tested.simulation
    simulation.spawn(simulation.plan(block("wall", (1.5, 0.0, 0.0), (0.3, 3.0, 1.0), 2000.0)))
    assert simulation.objects.frames() == ["wall/body"]
    drive(tested, 0.6, 2.0)
    assert 0.6 < place(tested)[0] < 0.9, "its front is at the wall"
    assert simulation.delete("wall") == ["wall"]
    drive(tested, 0.6, 2.0)
    assert place(tested)[0] > 1.5


def test_a_moved_object_goes_back_with_a_reset_and_ends_no_bookmark(robot, scene):
    tested = robot(world=scene(block("box", (1.5, 0.0, 0.0))))
    simulation = tested.simulation
    bookmarks = Bookmarks(simulation)
    bookmarks.save("before")
    changes = simulation.changes
    simulation.move("box", ((2.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0)))
    assert simulation.changes > changes, "so that a trial sees it"
    tested.run(0.2)
    assert place(tested, "box/body") == pytest.approx((2.0, 1.0, 0.0), abs=2e-3)
    bookmarks.restore("before")
    assert place(tested, "box/body") == pytest.approx((1.5, 0.0, 0.0), abs=2e-3)
    simulation.move("box", ((2.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0)))
    simulation.reset()
    assert place(tested, "box/body") == pytest.approx((1.5, 0.0, 0.0), abs=2e-3)
    for name, pose, message in (
        ("telex", (1.0, 1.0, 0.0), "that is a robot"),
        ("box", (0.0, 0.0, 0.1), "'box' would stand in the robot"),
        ("box", (90.0, 0.0, 0.0), "at most 80 m"),
    ):
        with pytest.raises(ConfigError, match=message):
            simulation.move(name, (pose, (0.0, 0.0, 0.0, 1.0)))


def test_a_surface_that_takes_the_number_of_one_that_went_has_its_own_friction(robot, scene):
    def pad(name, friction):
        return block(name, (0, 0, 0), (3.0, 2.0, 0.1), 5000.0, friction=friction)

    tested = robot(world=scene(pad("rough", 1.0), head="start: {ground: 0.1, pose: drive}"))
    tested.run(0.5)
    simulation = tested.simulation
    rough = simulation.objects.bodies_of("rough")
    simulation.delete("rough")
    pybullet.resetBasePositionAndOrientation(
        simulation.body.uid, (0, 0, 0.5), (0, 0, 0, 1), physicsClientId=simulation.world.client
    )
    simulation.spawn(simulation.plan(pad("ice", 0.01)))
    assert simulation.objects.bodies_of("ice") == rough
    tested.run(1.0)
    before = place(tested)[0]
    drive(tested, 0.5, 1.0)
    assert place(tested)[0] - before < 0.1


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (block("inside", (0, 0, 0)), "'inside' would stand in the robot"),
        (block("box", (3, 0, 0)), "name is 'box'; an object of this name exists already"),
        (block("telex", (3, 0, 0)), "that of another frame"),
        (block("new", (3, 0, 0), mass=-1.0), "mass is -1"),
        ("{type: mesh, mesh: /no/such.obj}", "/no/such.obj: there is no such file"),
        ("{type: unicorn}", "type is 'unicorn'"),
        ("LARGE", "10000000 bytes"),
        ("{type: crate, position: [.nan, 0, 0]}", "position[0] is nan"),
        ("", "a struct with the key 'type' is needed"),
        ("{", "no YAML"),
    ],
)
def test_what_cannot_be_spawned_changes_nothing(robot, scene, text, said):
    tested = robot(world=scene(block("box", (2, 0, 0))))
    simulation = tested.simulation
    tested.run(0.02)
    before, bodies = simulation.link_poses(), pybullet.getNumBodies(simulation.world.client)
    with pytest.raises(ConfigError) as caught:
        simulation.spawn(simulation.plan("- a\n" * 2_500_000 if text == "LARGE" else text))
    assert said in str(caught.value)
    assert simulation.link_poses() == before
    assert pybullet.getNumBodies(simulation.world.client) == bodies


@pytest.mark.parametrize("name", ["telex", "world", "floor", "nothing", ""])
def test_what_is_no_object_cannot_be_deleted(robot, name):
    tested = robot()
    bodies = pybullet.getNumBodies(tested.simulation.world.client)
    with pytest.raises(ConfigError, match=f"name is '{name}'; there is no such object"):
        tested.simulation.delete(name)
    assert pybullet.getNumBodies(tested.simulation.world.client) == bodies


def test_all_that_one_entry_made_goes_together_or_singly(robot, scene):
    tested = robot(world=scene("{type: pallet_stack, name: pile, position: [3, 0, 0]}"))
    simulation = tested.simulation
    names = [item.name for item in simulation.objects.objects()]
    assert len(names) > 2
    assert simulation.delete(names[-1]) == names[-1:]
    assert simulation.delete("pile") == names[:-1]
    assert simulation.objects.frames() == []


@pytest.mark.parametrize("kind", ["source_container", "beam_line"])
def test_a_second_entry_of_several_objects_gets_a_free_name_as_well(robot, kind):
    simulation = robot().simulation
    for number, y in enumerate((6.0, 12.0), 1):
        plans = simulation.plan(f"{{type: {kind}, position: [0, {y}, 0]}}")
        assert len(plans) > 1
        assert {plan.source.entry for plan in plans} == {f"{kind}_{number}"}
        simulation.spawn(plans)


def test_a_reset_brings_back_what_the_scene_file_says(robot, scene):
    tested = robot(
        world=scene(
            block("near", (1.2, 0.0, 0.0)),
            block("far", (5.0, 0.0, 0.0)),
            "{type: connector, name: plugged, position: [3, 2, 0]}",
            "{type: valve, name: valve, position: [3, -2, 0]}",
        ),
        start__pose="drive",
    )
    simulation = tested.simulation
    tested.run(0.5)
    fresh, frames = simulation.link_poses(), simulation.objects.frames()
    simulation.delete("far")
    simulation.spawn(simulation.plan(block("new", (2.0, 1.0, 0.0))))
    drive(tested, 0.6, 2.0)
    # Pushed: how far is a matter of how the tracks meet it.
    assert place(tested, "near/body")[0] > 1.202
    time = simulation.time
    simulation.reset()
    assert simulation.time == time
    assert simulation.objects.frames() == frames
    tested.run(0.5)
    assert simulation.link_poses() == fresh


def test_same_inputs_give_bit_identical_states_with_objects(robot, scene):
    path = scene(
        block("box", (1.0, 0.05, 0.0)),
        block("on_top", (1.0, 0.1, 0.3)),
        "{type: door, name: door, position: [2, 0, 0]}",
        "{type: connector, name: plugged, position: [1, 2, 0]}",
    )

    def run():
        tested = robot(world=path, start__pose="drive")
        drive(tested, 0.8, 1.5)
        tested.simulation.spawn(tested.simulation.plan(block("late", (1.5, 1.0, 0.5))))
        tested.run(0.5)
        return tested.simulation.link_poses()

    assert run() == run()


def test_objects_can_be_planned_beside_the_loop(robot):
    tested = robot()
    simulation = tested.simulation
    plans = []
    thread = threading.Thread(
        target=lambda: plans.extend(
            simulation.plan(block(f"b{n}", (2 + n, 2, 0)))[0] for n in range(20)
        )
    )
    thread.start()
    while thread.is_alive():
        tested.run(0.01)
        thread.join(0.0)
    simulation.spawn(plans)
    assert len(simulation.objects.frames()) == 20
    tested.run(0.5)
    assert all(math.isfinite(value) for value in simulation.link_poses())
