"""Equipment of a variant: what a robot has, what its range finder reads, and what is told."""

from __future__ import annotations

import math
from xml.etree import ElementTree

import numpy as np
import pybullet
import pytest

from telex_control.common.params import ConfigError
from telex_sim.engine.bookmarks import Bookmarks
from telex_sim.equipment.equipment_config import EquipmentConfig, RangeFinderConfig
from telex_sim.equipment.object_width import MOST, object_width
from telex_sim.equipment.range_finder import RangeFinder
from telex_sim.offline.simulation import OfflineSimulation
from telex_sim.proximity.monitor import NearPair, Proximity
from telex_sim.proximity.places import Place
from telex_sim.robot.gripper.contact import GripperContact, PadContact
from telex_sim.ros.sensors import equipment_publisher

pytestmark = pytest.mark.slow

FACE = 3.0
SCENE = f"""
objects:
  - {{type: wall, position: [{FACE + 0.05}, 0, 0], yaw: 1.5707963, length: 8, height: 4,
      thickness: 0.1}}
"""
LINK = "range_finder_link"


@pytest.fixture
def before_a_wall(robot, tmp_path):
    path = tmp_path / "wall.yaml"
    path.write_text(SCENE)

    def make(**changes):
        return robot(world=str(path), **changes)

    return make


def aim(robot):
    """Put the arm's joints so that the tool looks ahead, level."""
    body = robot.body
    lean = 0.6
    for joint, angle in (("shoulder", -lean), ("elbow", 2 * lean), ("wrist_pitch", -lean)):
        index = body.joints[f"{joint}_joint"]
        pybullet.resetJointState(body.uid, index, angle, physicsClientId=body.client)


def fingers(robot, angle):
    body = robot.body
    for side in ("left", "right"):
        for part, ratio in (("base", 1), ("middle", 1), ("tip", -2)):
            index = body.joints[f"{side}_finger_{part}_joint"]
            pybullet.resetJointState(body.uid, index, ratio * angle, physicsClientId=body.client)


def truth(robot, link=LINK):
    """Distance to the wall along the axis of a link."""
    position, orientation = robot.body.pose(link)
    forward = pybullet.getMatrixFromQuaternion(orientation)[0]
    return (FACE - position[0]) / forward


def put(robot, shape, distance, **size):
    """Put something that does not move on the tool's axis."""
    body = robot.body
    kind = {"box": pybullet.GEOM_BOX, "sphere": pybullet.GEOM_SPHERE}[shape]
    made = pybullet.createCollisionShape(kind, physicsClientId=body.client, **size)
    position, orientation = body.pose("tool_link")
    place, _ = pybullet.multiplyTransforms(position, orientation, (distance, 0, 0), (0, 0, 0, 1))
    pybullet.createMultiBody(
        baseCollisionShapeIndex=made,
        basePosition=place,
        baseOrientation=orientation,
        physicsClientId=body.client,
    )


class TestObjectWidth:
    @pytest.mark.parametrize(
        ("shape", "size", "width"),
        [
            ("box", {"halfExtents": [0.05, 0.03, 0.2]}, 0.06),
            ("box", {"halfExtents": [0.004, 0.03, 0.2]}, 0.06),  # thinner than fingers reach
            ("sphere", {"radius": 0.04}, 0.08),
            ("box", {"halfExtents": [0.05, 0.5, 0.2]}, MOST),
        ],
    )
    def test_it_is_what_fingers_would_have_to_open(self, before_a_wall, shape, size, width):
        robot = before_a_wall().simulation.robots[0]
        aim(robot)
        fingers(robot, 0.35)
        put(robot, shape, 0.3, **size)
        assert object_width(robot.body, LINK, "tool_link", 2.0) == pytest.approx(width, abs=2e-3)

    def test_neighbours_do_not_count(self, before_a_wall):
        robot = before_a_wall().simulation.robots[0]
        aim(robot)
        fingers(robot, 0.35)
        put(robot, "box", 0.3, halfExtents=[0.05, 0.03, 0.2])
        put(robot, "box", 0.3, halfExtents=[0.05, 0.02, 0.2], collisionFramePosition=[0, 0.12, 0])
        assert object_width(robot.body, LINK, "tool_link", 2.0) == pytest.approx(0.06, abs=2e-3)

    def test_there_is_none_of_nothing_and_of_the_robot_itself(self, before_a_wall):
        robot = before_a_wall().simulation.robots[0]
        aim(robot)
        fingers(robot, 0.35)
        assert math.isnan(object_width(robot.body, LINK, "tool_link", 0.5))
        fingers(robot, 0.0)
        assert math.isnan(object_width(robot.body, LINK, "tool_link", 2.0))


class TestRangeFinder:
    def test_it_reads_the_distance_along_its_axis_with_its_noise(self, before_a_wall):
        robot = before_a_wall().simulation.robots[0]
        aim(robot)
        fingers(robot, 0.35)
        config = RangeFinderConfig(link=LINK, noise=0.01, noise_share=0.02, resolution=0.005)
        finder = RangeFinder(robot, config)
        there = truth(robot)
        assert 1.5 < there < 3.0
        readings = np.array([finder.measure() for _ in range(1000)])
        deviation = 0.01 + 0.02 * there
        assert readings.mean() == pytest.approx(there, abs=4.0 * deviation / math.sqrt(1000))
        assert readings.std() == pytest.approx(deviation, rel=0.1)
        assert np.allclose(readings / 0.005, np.round(readings / 0.005), atol=1e-6)

    def test_fingers_stand_in_its_way_and_its_own_housing_does_not(self, before_a_wall):
        robot = before_a_wall().simulation.robots[0]
        aim(robot)
        exact = {"noise": 0.0, "noise_share": 0.0, "resolution": 0.0}
        finder = RangeFinder(robot, RangeFinderConfig(link=LINK, **exact))
        fingers(robot, 0.0)
        assert finder.measure() == pytest.approx(0.076, abs=0.01)
        fingers(robot, 0.35)
        assert finder.measure() == pytest.approx(truth(robot), abs=1e-3)
        # From within the palm it looks out of it.
        inside = RangeFinder(robot, RangeFinderConfig(link="gripper_link", **exact))
        assert inside.measure() == pytest.approx(truth(robot, "gripper_link"), abs=1e-3)

    def test_beyond_its_limits_it_reads_infinities(self, before_a_wall):
        robot = before_a_wall().simulation.robots[0]
        aim(robot)
        fingers(robot, 0.35)
        there = truth(robot)
        assert (
            RangeFinder(robot, RangeFinderConfig(link=LINK, max=there - 0.3)).measure() == math.inf
        )
        near = RangeFinderConfig(link=LINK, min=there + 0.3, max=9.0)
        assert RangeFinder(robot, near).measure() == -math.inf
        sky = robot.body.joints["shoulder_joint"]
        pybullet.resetJointState(robot.body.uid, sky, -2.2, physicsClientId=robot.body.client)
        assert RangeFinder(robot, RangeFinderConfig(link=LINK)).measure() == math.inf

    def test_its_errors_begin_anew_with_the_robot_and_go_back_with_a_bookmark(self, before_a_wall):
        simulation = before_a_wall().simulation
        robot = simulation.robots[0]
        finder = RangeFinder(robot, RangeFinderConfig(link=LINK, resolution=0.0))
        robot.watchers = (*robot.watchers, finder)

        def readings():
            aim(robot)
            fingers(robot, 0.35)
            return [finder.measure() - truth(robot) for _ in range(5)]

        first = readings()
        bookmarks = Bookmarks(simulation)
        bookmarks.save("here")
        second = readings()
        assert first != second
        bookmarks.restore("here")
        assert readings() == pytest.approx(second, abs=1e-9)
        simulation.reset()
        assert readings() == pytest.approx(first, abs=1e-9)

    @pytest.mark.parametrize(
        "wrong",
        [
            {"rate": 0.0},
            {"rate": math.nan},
            {"min": -0.1},
            {"max": 0.01},
            {"max": math.inf},
            {"noise": -1.0},
            {"noise_share": 2.0},
            {"resolution": math.nan},
            {"resolution": 1e-310},
            {"topic": ""},
            {"topic": "/elsewhere"},
            {"topic": "two words"},
            {"field_of_view": 7.0},
        ],
    )
    def test_one_that_cannot_be_is_refused(self, wrong):
        with pytest.raises(ConfigError, match=next(iter(wrong))):
            RangeFinderConfig(**wrong)


def test_a_robot_has_what_it_has_the_links_of():
    config = EquipmentConfig(range_finder=RangeFinderConfig(link="eye"))
    assert config.present(["eye", "arm"]) == ("range_finder",)
    assert config.present(["arm", ""]) == ()


class Wire:
    """Parameters and topics of rospy, as far as equipment uses them."""

    def __init__(self, monkeypatch):
        self.params = {}
        self.topics = {}
        self.heard = 1
        rospy = equipment_publisher.rospy
        monkeypatch.setattr(rospy, "set_param", self.params.__setitem__)
        monkeypatch.setattr(rospy, "delete_param", self.params.__delitem__)
        monkeypatch.setattr(rospy, "Publisher", self.publisher)

    def publisher(self, name, kind, **_):
        wire, said = self, self.topics.setdefault(name, [])

        class Publisher:
            resolved_name = name

            def get_num_connections(self):
                return wire.heard

            def publish(self, message):
                if not isinstance(message, float):
                    message = (message.header.frame_id, message.min_range, message.range)
                said.append(message)

            def unregister(self):
                del wire.topics[name]

        return Publisher()


@pytest.fixture
def wire(monkeypatch):
    return Wire(monkeypatch)


def without(urdf, *ends):
    """The robot without the frames whose names end so."""
    root = ElementTree.fromstring(urdf)
    for element in [*root.findall("link"), *root.findall("joint")]:
        name = element.get("name").replace("_fixed_joint", "")
        if name.endswith(ends):
            root.remove(element)
    return ElementTree.tostring(root, encoding="unicode")


class TestTelling:
    def test_the_standard_robot_has_all_but_proximity(self, wire, before_a_wall):
        robot = before_a_wall().simulation.robots[0]
        told = equipment_publisher.EquipmentPublisher(robot)
        name = robot.namespace
        here, aids = wire.params[f"{name}/equipment"], wire.params[f"{name}/training_aids"]
        assert sorted(here) == ["laser_dots", "microphone", "pads", "range_finder"]
        finder = {"frame": LINK, "max": 10.0, "min": 0.05, "rate": 20.0}
        assert here["range_finder"] == {**finder, "topic": f"{name}/range_finder"}
        assert here["laser_dots"]["frames"] == ["left_laser_link", "right_laser_link"]
        assert sorted(aids) == ["object_width", "proximity"]
        assert aids["object_width"] == {"topic": f"{name}/sim/object_width"}
        told.publish_range(equipment_publisher.rospy.Time(1))
        wire.heard = 0
        told.publish_range(equipment_publisher.rospy.Time(2))
        assert len(wire.topics[f"{name}/sim/object_width"]) == 1
        ((frame, nearest, _),) = wire.topics[f"{name}/range_finder"]
        assert (frame, nearest) == (LINK, 0.05)
        told.close()
        assert (wire.params, wire.topics) == ({}, {})

    def test_what_a_robot_lacks_has_an_exact_stand_in_where_there_is_one(self, wire, urdf):
        bare = without(urdf, "_laser_link", "_pad_link", "microphone_link", LINK)
        simulation = OfflineSimulation(bare).simulation
        robot = simulation.robots[0]
        told = equipment_publisher.EquipmentPublisher(robot)
        name = robot.namespace
        assert wire.params[f"{name}/equipment"] == {}
        aids = wire.params[f"{name}/training_aids"]
        assert sorted(aids) == ["object_width", "pads", "proximity", "range_finder"]
        assert aids["range_finder"]["topic"] == f"{name}/sim/range_finder"
        aim(robot)
        told.publish_range(equipment_publisher.rospy.Time(1))
        told.publish_range(equipment_publisher.rospy.Time(2))
        first, second = wire.topics[f"{name}/sim/range_finder"]
        assert first == second
        assert first[0] == "tool_link"
        near, contact = a_pair(0.01), a_grasp(100.0, 0.0)
        assert told.sensed(near) == near
        assert told.felt(contact) == contact
        simulation.close()

    def test_pads_and_sensors_err_within_their_limits(self, wire, before_a_wall):
        robot = before_a_wall().simulation.robots[0]
        robot.equipment = (*robot.equipment, "proximity")
        told = equipment_publisher.EquipmentPublisher(robot)
        forces = [told.felt(a_grasp(100.0, 0.0)) for _ in range(400)]
        assert np.std([each.force for each in forces]) == pytest.approx(0.3, rel=0.2)
        assert {each.pads[1].normal_force for each in forces} == {0.0}
        assert told.felt(a_grasp(5000.0, 0.0)).force == 400.0
        near = [told.sensed(a_pair(0.01)).pairs[0].place.distance for _ in range(400)]
        assert np.std(near) == pytest.approx(0.002, rel=0.2)
        assert list(wire.params[f"{robot.namespace}/training_aids"]) == ["object_width"]


def a_pair(distance):
    place = Place(distance, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0,))
    return Proximity((0.0,), (NearPair(place, "gripper_link", "floor", False, 0.0),))


def a_grasp(force, other):
    pads = tuple(PadContact("pad", ("cube",), each, each, 0.1, 0.0) for each in (force, other))
    return GripperContact(0.05, force, "cube", False, 0.0, pads)
