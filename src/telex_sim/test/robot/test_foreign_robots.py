"""Robots that are not Telex, in a simulation of their own and beside Telex."""

from __future__ import annotations

import math
import shutil
import tempfile
import threading
from pathlib import Path

import pybullet
import pybullet_data
import pytest
import rospkg
from geometry_msgs.msg import Twist
from std_msgs.msg import Float64, Float64MultiArray

from telex_control.common.params import ConfigError, read_config
from telex_control.hardware.hardware_interface import EffortJointInterface
from telex_control.ros.local_node_handle import LocalNodeHandle
from telex_control.urdf.joints import MOVABLE, UrdfError, joints, parse_urdf
from telex_control.urdf.model import read_xml
from telex_sim.engine.bookmarks import Bookmarks
from telex_sim.engine.simulation import Simulation
from telex_sim.engine.simulator_config import RobotConfig, SimulatorConfig
from telex_sim.robot.model import robot_model
from telex_sim.scene.addresses import resolve_address

pytestmark = pytest.mark.slow

DATA = Path(pybullet_data.getDataPath())
TRANSMISSION = """
<transmission name="{joint}_drive"><type>transmission_interface/SimpleTransmission</type>
<joint name="{joint}"><hardwareInterface>hardware_interface/{interface}</hardwareInterface></joint>
<actuator name="{joint}_motor"><mechanicalReduction>1</mechanicalReduction></actuator>
</transmission>"""
KUKA = [f"lbr_iiwa_joint_{number}" for number in range(1, 8)]
PANDA = [f"panda_joint{number}" for number in range(1, 8)]
POSTURE = (0.4, 0.5, -0.3, -0.8, 0.2, 0.6, 0.3)


def with_transmissions(tmp_path, file, interface, unscoped=""):
    """URDF of a robot of pybullet_data, which has no transmissions by itself."""
    source = DATA / file
    text = source.read_text().replace(unscoped or "\0", "")
    text = text.replace('filename="meshes/', f'filename="{source.parent}/meshes/')
    driven = [joint.name for joint in parse_urdf(text).joints if joint.type in MOVABLE]
    added = "".join(TRANSMISSION.format(joint=joint, interface=interface) for joint in driven)
    path = tmp_path / source.name
    path.write_text(text.replace("</robot>", added + "</robot>"))
    return robot_model(path)


@pytest.fixture
def kuka(tmp_path):
    """Commanded by position through its motors."""
    params = {
        "joint_state_controller": {
            "type": "joint_state_controller/JointStateController",
            "publish_rate": 50,
        },
        "arm": {"type": "position_controllers/JointGroupPositionController", "joints": KUKA},
    }
    return with_transmissions(tmp_path, "kuka_iiwa/model.urdf", "PositionJointInterface"), params


@pytest.fixture
def panda(tmp_path):
    """Commanded by velocity, with a position loop around it."""
    params = {
        f"{joint}_position": {
            "type": "velocity_controllers/JointPositionController",
            "joint": joint,
            "pid": {"p": 8.0},
        }
        for joint in PANDA
    }
    urdf = with_transmissions(
        tmp_path, "franka_panda/panda.urdf", "VelocityJointInterface", "package://"
    )
    return urdf, params


def config(kind=RobotConfig, place=(0.0, 0.0, 0.0, 0.0), **values):
    params = {
        "fixed_base": True,
        "self_collision": {"enabled": False},
        "start": {"place": place},
        **values,
    }
    return read_config(kind, params, "test")


def resolve(address):
    return resolve_address(address, rospkg.RosPack().get_path)


def start(simulation, robot, params):
    """Load and start all controllers of a robot."""
    names = [name for name, value in params.items() if "type" in value]
    if not names:
        return
    for name in names:
        assert robot.controllers.load_controller(name), name
    answer = []
    thread = threading.Thread(
        target=lambda: answer.append(robot.controllers.switch_controller(names, []))
    )
    thread.start()
    while thread.is_alive():
        simulation.idle()
        thread.join(0.001)
    assert answer == [True]


def run(simulation, seconds):
    for _ in range(round(seconds / simulation.config.timing.step_size)):
        simulation.step()


def node_of(urdf, params, namespace=""):
    tree = {**params, "robot_description": urdf}
    for part in reversed(namespace.strip("/").split("/") if namespace else []):
        tree = {part: tree}
    return LocalNodeHandle(tree, namespace)


@pytest.fixture
def alone():
    """Makes simulations of one foreign robot."""
    made = []

    def make(urdf, params, **values):
        node = node_of(urdf, params)
        made.append(Simulation(config(SimulatorConfig, **values), urdf, node, resolve))
        start(made[-1], made[-1].robots[0], params)
        return made[-1], node

    yield make
    for simulation in made:
        simulation.close()


POST = (
    '<robot name="post"><link name="post"><collision><origin xyz="0 0 0.5"/><geometry>'
    '<box size="0.4 0.4 1"/></geometry></collision></link></robot>'
)


@pytest.fixture
def post(alone):
    """A simulation of a robot that is hardly one, to add others to."""
    return alone(POST, {}, model="post")[0]


def beside(simulation, robot, namespace="/other", place=(2.0, 0.0, 0.0, 0.0)):
    """Add a robot to a simulation, and start its controllers."""
    urdf, params = robot
    node = node_of(urdf, params, namespace)
    added = simulation.plan_robot(config(place=place), urdf, node)
    simulation.add_robot(added)
    start(simulation, added, params)
    return added, node


def command_panda(node):
    for joint, position in zip(PANDA, POSTURE):
        node.advertise(f"{joint}_position/command", Float64).publish(Float64(position))


def command_kuka(node, posture=POSTURE):
    node.advertise("arm/command", Float64MultiArray).publish(Float64MultiArray(data=posture))


def test_a_kuka_alone_follows_positions_by_its_motors(alone, kuka):
    simulation, node = alone(*kuka, model="kuka")
    command_kuka(node)
    run(simulation, 1.0)
    positions = simulation.hw.joint_positions()
    for joint, wanted in zip(KUKA, POSTURE):
        assert positions[joint] == pytest.approx(wanted, abs=1e-3), joint
    assert simulation.body.base_pose()[0] == pytest.approx((0, 0, 0), abs=1e-9)
    # It rolls on nothing, and is fed by a cable.
    assert simulation.robots[0].surface() == ""
    assert "battery" not in {each.what for each in simulation.robots[0].malfunctions.possible()}


def test_a_panda_alone_follows_positions_by_its_velocities(alone, panda):
    simulation, node = alone(*panda, model="panda")
    command_panda(node)
    run(simulation, 1.3)
    positions = simulation.hw.joint_positions()
    for joint, wanted in zip(PANDA, POSTURE):
        assert positions[joint] == pytest.approx(wanted, abs=5e-3), joint
    # the fingers have drives but no controllers: their brakes hold them
    assert positions["panda_finger_joint1"] == pytest.approx(0.0, abs=1e-3)


HUSKY = {side: [f"{end}_{side}_wheel" for end in ("front", "rear")] for side in ("left", "right")}


@pytest.fixture
def husky():
    """Driven by its wheels, which have neither a velocity nor an effort limit."""
    params = {
        "drive": {
            "type": "diff_drive_controller/DiffDriveController",
            "left_wheel": HUSKY["left"],
            "right_wheel": HUSKY["right"],
            "wheel_separation_multiplier": 1.875,
            "cmd_vel_timeout": 10.0,
            "publish_rate": 50.0,
            "pose_covariance_diagonal": [0.01] * 6,
            "twist_covariance_diagonal": [0.01] * 6,
        }
    }
    return robot_model(DATA / "husky" / "husky.urdf"), params


def drive(node, linear, angular):
    message = Twist()
    message.linear.x, message.angular.z = linear, angular
    node.advertise("drive/cmd_vel", Twist).publish(message)


def test_a_husky_drives_on_wheels_without_limits(alone, husky):
    place = (0.0, 0.0, 0.15, 0.0)
    simulation, node = alone(*husky, model="husky", place=place, fixed_base=False, battery={})
    assert simulation.robots[0].malfunctions.charge().share == 1.0
    run(simulation, 0.5)
    assert simulation.robots[0].surface() == "concrete"
    (start, _, _), _ = simulation.body.base_pose()
    drive(node, 0.8, 0.0)
    run(simulation, 2.0)
    (x, y, _), _ = simulation.body.base_pose()
    assert x - start == pytest.approx(1.6, rel=0.05)
    assert abs(y) < 0.02
    drive(node, 0.0, 0.8)
    run(simulation, 1.0)
    wheels = {name: simulation.hw.joint_state(name) for names in HUSKY.values() for name in names}
    # half the separation, times the multiplier, over the radius, as the URDF has them
    speed = 0.8 * 0.2854 * 1.875 / 0.17775
    for name, state in wheels.items():
        assert state.velocity == pytest.approx(-speed if "left" in name else speed, rel=0.02), name
    # it turns, although its wheels slip
    assert pybullet.getEulerFromQuaternion(simulation.body.base_pose()[1])[2] > 0.1
    drive(node, 0.0, 0.0)
    run(simulation, 1.0)
    assert max(abs(state.velocity) for state in wheels.values()) < 0.01


def test_a_pole_without_limits_takes_any_effort_that_is_a_number(alone, tmp_path):
    urdf = with_transmissions(tmp_path, "cartpole.urdf", "EffortJointInterface")
    params = {"pole": {"type": "effort_controllers/JointEffortController", "joint": "cart_to_pole"}}
    simulation, node = alone(urdf, params, place=(0.0, 0.0, 1.0, 0.0))
    node.advertise("pole/command", Float64).publish(Float64(3.0))
    run(simulation, 0.5)
    # 3 N m on 1.025 kg m2 about the joint; gravity, 0.49 N m at most, helps a little
    angle = simulation.hw.joint_positions()["cart_to_pole"]
    assert angle == pytest.approx(0.5 * 3.0 / 1.025 * 0.5**2, rel=0.03)
    handle = simulation.hw.get(EffortJointInterface).get_handle("cart_to_pole")
    for bad in (math.nan, math.inf):
        handle.command = bad
        simulation.hw.write(simulation.time, 0.002)
        assert handle.command == 0.0


def test_two_foreign_robots_beside_telex_obey_their_own_commands(robot, kuka, panda):
    telex = robot()
    simulation = telex.simulation
    first, kuka_node = beside(simulation, kuka, "/kuka", (2.0, 0.0, 0.0, 1.0))
    second, panda_node = beside(simulation, panda, "/cell/panda", (-2.0, 0.0, 0.0, 0.0))
    assert [each.model for each in simulation.robots] == ["telex", "kuka", "panda"]
    before = telex.positions()
    command_kuka(kuka_node)
    command_panda(panda_node)
    run(simulation, 1.3)
    for added, names in ((first, KUKA), (second, PANDA)):
        positions = added.hw.joint_positions()
        for joint, wanted in zip(names, POSTURE):
            assert positions[joint] == pytest.approx(wanted, abs=5e-3), joint
    for joint, position in telex.positions().items():
        if "track" not in joint:
            assert position == pytest.approx(before[joint], abs=3e-3), joint
    yaw = pybullet.getEulerFromQuaternion(first.body.base_pose()[1])[2]
    assert yaw == pytest.approx(1.0)
    count = sum(len(each.body.link_names()) for each in simulation.robots)
    assert len(simulation.link_poses()) == 7 * count


def test_an_emergency_stop_is_the_robots_own(post, kuka):
    stopped, stopped_node = beside(post, kuka)
    other, other_node = beside(post, kuka, "/free", (-2.0, 0.0, 0.0, 0.0))
    stopped.request_e_stop(True)
    for node in (stopped_node, other_node):
        command_kuka(node)
    run(post, 1.0)
    assert [each.hw.e_stop for each in post.robots] == [False, True, False]
    assert max(map(abs, stopped.hw.joint_positions().values())) < 1e-3
    assert other.hw.joint_positions()[KUKA[0]] == pytest.approx(POSTURE[0], abs=1e-3)
    stopped.request_e_stop(False)
    run(post, 0.5)
    assert max(map(abs, stopped.hw.joint_positions().values())) < 1e-3
    command_kuka(stopped_node)
    run(post, 1.0)
    assert stopped.hw.joint_positions()[KUKA[0]] == pytest.approx(POSTURE[0], abs=1e-3)


def test_a_reset_puts_added_robots_back_to_the_last_bit(robot, kuka):
    telex = robot()
    simulation = telex.simulation
    _, node = beside(simulation, kuka)
    simulation.reset()
    telex.run(0.1)
    fresh = simulation.link_poses()
    command_kuka(node)
    telex.run(0.2)
    assert simulation.link_poses() != fresh
    simulation.reset()
    telex.run(0.1)
    assert simulation.link_poses() == fresh


def states(simulation):
    """Poses of all that moves, and what is measured of all joints."""
    measured = [
        (state.position, state.velocity, state.effort)
        for robot in simulation.robots
        for state in map(robot.hw.joint_state, robot.hw.joint_positions())
    ]
    return simulation.link_poses(), measured


def require_bookmark(simulation, command):
    """Set a bookmark while something moves, go back twice, and do the same again."""
    bookmarks = Bookmarks(simulation)
    command()
    run(simulation, 0.3)
    there = simulation.link_poses()
    bookmarks.save("there")
    ends = []
    for _ in range(2):
        run(simulation, 0.4)
        bookmarks.restore("there")
        assert simulation.link_poses() == pytest.approx(there, abs=1e-9)
        command()
        run(simulation, 0.4)
        ends.append(states(simulation))
    assert ends[0][0] != pytest.approx(there, abs=1e-3)
    assert ends[0] == ends[1]


def test_a_bookmark_holds_for_one_with_a_fixed_base(alone, kuka):
    simulation, node = alone(*kuka, model="kuka")
    require_bookmark(simulation, lambda: command_kuka(node))


def test_a_bookmark_holds_for_one_without_tracks(alone, husky):
    place = (0.0, 0.0, 0.15, 0.0)
    simulation, node = alone(*husky, model="husky", place=place, fixed_base=False)
    require_bookmark(simulation, lambda: drive(node, 0.8, 0.3))
    simulation.reset()
    assert simulation.body.base_pose()[0] == pytest.approx(place[:3], abs=1e-6)


def test_a_bookmark_holds_for_all_robots_of_a_simulator(robot, kuka, panda):
    simulation = robot().simulation
    _, first = beside(simulation, kuka)
    _, second = beside(simulation, panda, "/panda", (-2.0, 0.0, 0.0, 0.0))

    def command():
        command_kuka(first)
        command_panda(second)

    require_bookmark(simulation, command)
    bookmarks = Bookmarks(simulation)
    bookmarks.save("before")
    simulation.remove_robot("/panda")
    with pytest.raises(ConfigError, match="'before' has ended: robot 'panda' was removed"):
        bookmarks.restore("before")


def test_same_inputs_give_bit_identical_states_of_all_robots(alone, kuka):
    def poses():
        simulation, first = alone(*kuka, model="first")
        _, second = beside(simulation, kuka, place=(0.5, 0.0, 0.0, 0.0))
        command_kuka(first)
        command_kuka(second, [-each for each in POSTURE])
        run(simulation, 0.2)
        return simulation.link_poses()

    assert poses() == poses()


def test_a_robot_that_is_removed_leaves_nothing(post, kuka):
    bodies, poses = post.world.bodies(), post.link_poses()
    for _ in range(2):
        beside(post, kuka)
        assert len(post.world.bodies()) == len(bodies) + 1
        run(post, 0.1)
        post.remove_robot("/other")
        assert post.world.bodies() == bodies
        assert len(post.link_poses()) == len(poses)
        run(post, 0.1)


@pytest.mark.parametrize(
    ("place", "model", "named"),
    [
        ((0.0, 0.0, 0.0, 0.0), "", "it would stand in robot 'post'"),
        ((2.0, 0.0, -0.3, 0.0), "", "it would stand in the ground"),
        ((2.0, 0.0, 0.0, 0.0), "post", "model is 'post'"),
        ((2.0, 0.0, 0.0, 0.0), "world", "model is 'world'"),
    ],
)
def test_a_robot_that_cannot_be_there_is_refused(post, kuka, place, model, named):
    simulation = post
    urdf, params = kuka
    before = simulation.world.bodies()
    added = simulation.plan_robot(
        config(place=place, model=model), urdf, node_of(urdf, params, "/other")
    )
    with pytest.raises(ConfigError, match=named):
        simulation.add_robot(added)
    assert simulation.world.bodies() == before
    assert len(simulation.robots) == 1
    simulation.step()


def test_a_namespace_is_for_one_robot(post, kuka):
    simulation = post
    beside(simulation, kuka)
    urdf, params = kuka
    again = simulation.plan_robot(config(model="again"), urdf, node_of(urdf, params, "/other"))
    with pytest.raises(ConfigError, match="there is a robot already"):
        simulation.add_robot(again)
    with pytest.raises(ConfigError, match="robots that were added: /other"):
        simulation.remove_robot("/no/such")


@pytest.mark.parametrize(
    ("change", "error", "named"),
    [
        (('effort="300"', 'effort="0"'), UrdfError, "max_effort is 0.0"),
        (("PositionJointInterface", "PosVelJointInterface"), UrdfError, "simulated are"),
        (("</robot>", ""), UrdfError, "is no XML"),
        (("file:///", "package://nowhere/"), ConfigError, "nowhere"),
        (("link_0.stl", "no_such.stl"), ConfigError, "PyBullet cannot load"),
    ],
)
def test_a_bad_description_is_refused_and_the_loop_goes_on(post, kuka, change, error, named):
    simulation = post
    urdf, params = kuka
    urdf = urdf.replace(*change)

    def add():
        node = node_of(urdf, params, "/other")
        added = simulation.plan_robot(config(place=(2.0, 0.0, 0.0, 0.0)), urdf, node)
        simulation.add_robot(added)

    with pytest.raises(error, match=named):
        add()
    assert len(simulation.robots) == 1
    simulation.step()


def pads(urdf):
    """Two frames on the last link of a Kuka, which are no part of what PyBullet has."""
    added = "".join(
        f'<link name="{name}"/><joint name="{name}_joint" type="fixed">'
        f'<parent link="lbr_iiwa_link_7"/><child link="{name}"/></joint>'
        for name in ("left", "right")
    )
    return urdf.replace("</robot>", added + "</robot>")


def test_pads_that_can_touch_nothing_are_refused_by_name(alone, post, kuka):
    urdf, params = pads(kuka[0]), kuka[1]
    wanted = {"gripper_contact": {"pads": ["left", "right"]}}
    said = "gripper_contact/pads: the link 'left' has no <collision>"
    with pytest.raises(ConfigError, match=said):
        alone(urdf, params, **wanted)
    node = node_of(urdf, params, "/other")
    with pytest.raises(ConfigError, match=said):
        post.plan_robot(config(**wanted), urdf, node)


def test_of_a_robot_that_fails_unforeseen_nothing_stays(post, kuka, monkeypatch):
    urdf, params = kuka
    before = post.world.bodies()
    node = node_of(urdf, params, "/other")
    added = post.plan_robot(config(place=(2.0, 0.0, 0.0, 0.0)), urdf, node)

    def fail(_body):
        raise KeyError("no such thing")

    monkeypatch.setattr(added.hw, "attach", fail)
    with pytest.raises(KeyError, match="no such thing"):
        post.add_robot(added)
    assert post.world.bodies() == before
    assert len(post.robots) == 1
    post.step()


def test_a_reset_without_room_for_temporary_files_is_refused_and_changes_nothing(
    post, kuka, monkeypatch, tmp_path
):
    beside(post, kuka)
    post.spawn(post.plan("{type: crate, name: box, position: [-2.0, 0.0, 0.0]}"))
    run(post, 0.1)
    before, structure = post.link_poses(), (post.structure, post.changes)
    with monkeypatch.context() as patch:
        patch.setattr(tempfile, "tempdir", str(tmp_path / "full"))
        with pytest.raises(ConfigError, match="robot 'post' cannot be loaded again: .*No such"):
            post.reset()
    assert (post.link_poses(), (post.structure, post.changes)) == (before, structure)
    run(post, 0.1)
    post.reset()
    assert post.objects.objects() == []
    run(post, 0.1)


def test_a_reset_can_do_without_meshes_that_were_read(post, kuka, tmp_path):
    urdf, params = kuka
    meshes = tmp_path / "meshes"
    shutil.copytree(DATA / "kuka_iiwa" / "meshes", meshes)
    beside(post, (urdf.replace(str(DATA / "kuka_iiwa" / "meshes"), str(meshes)), params))
    before = post.link_poses()
    run(post, 0.1)
    shutil.rmtree(meshes)
    post.reset()
    assert post.link_poses() == before
    run(post, 0.1)


def test_relative_meshes_are_found_from_the_robots_file(tmp_path):
    folder = tmp_path / "a robot"
    folder.mkdir()
    path = folder / "r.urdf"
    path.write_text(
        '<robot name="r"><link name="a"><visual><geometry><mesh filename="m/x.stl"/>'
        '<mesh filename="package://p/y.stl"/></geometry></visual></link></robot>'
    )
    meshes = [mesh.get("filename") for mesh in read_xml(robot_model(path)).iter("mesh")]
    assert resolve(meshes[0]) == str(folder / "m" / "x.stl")
    assert meshes[1] == "package://p/y.stl"
    with pytest.raises(UrdfError, match=r"none\.urdf"):
        robot_model(tmp_path / "none.urdf")


def test_options_may_do_without_the_colon_that_roslaunch_would_read(tmp_path):
    path = tmp_path / "r.xacro"
    path.write_text(
        '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'
        '<xacro:arg name="arm" default="short"/><link name="$(arg arm)"/></robot>'
    )
    for option in ("arm=long", "arm:=long"):
        assert list(parse_urdf(robot_model(path, [option])).link_map) == ["long"]


def test_a_root_link_named_world_is_the_world(alone, kuka):
    urdf, params = kuka
    urdf = urdf.replace(
        "</robot>",
        '<link name="world"/><joint name="foot" type="fixed"><parent link="world"/>'
        '<child link="lbr_iiwa_link_0"/><origin xyz="0 0 0.5"/></joint></robot>',
    )
    simulation, _ = alone(urdf, params, fixed_base=False)
    run(simulation, 0.5)
    poses = dict(zip(simulation.body.link_names(), zip(*[iter(simulation.link_poses())] * 7)))
    assert poses["lbr_iiwa_link_0"][:3] == pytest.approx((0, 0, 0.5), abs=1e-9)


def test_the_robot_has_the_mass_of_its_description(alone, kuka):
    urdf, params = kuka
    urdf = urdf.replace(
        "</robot>",
        '<link name="tool"/><joint name="mount" type="fixed"><parent link="lbr_iiwa_link_7"/>'
        '<child link="tool"/></joint></robot>',
    )
    simulation, _ = alone(urdf, params, fixed_base=False)
    body, client = simulation.body, simulation.world.client
    masses = [
        pybullet.getDynamicsInfo(body.uid, link, physicsClientId=client)[0]
        for link in body.links.values()
    ]
    described = sum(link.inertial.mass for link in parse_urdf(urdf).links if link.inertial)
    assert math.isclose(sum(masses), described, rel_tol=1e-5)
    assert len(joints(parse_urdf(urdf))) == 7
