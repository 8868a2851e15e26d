"""Further robots begin where the scene says, whenever they come; a reset puts them back there."""

from __future__ import annotations

import pytest

from telex_sim.offline.robot import OfflineRobot
from telex_sim.offline.simulation import OfflineSimulation, robot_description
from telex_sim.scene.files.scene_file import SceneError
from telex_sim.scene.robot_in_scene import place_robot

pytestmark = pytest.mark.slow

TWO = "robots: [{x: -0.5, y: -2.0, yaw: 1.0, pose: drive}]\nobjects: []\n"


@pytest.fixture
def offline():
    made = OfflineSimulation(robot_description(), world="floor")
    yield made
    made.simulation.close()


def change(offline, text):
    simulation = offline.simulation
    simulation.change_scene(simulation.plan_scene(text))


def place(robot):
    (x, y, _), _ = robot.base_pose()
    return round(x, 2), round(y, 2)


def test_it_starts_where_the_scene_has_a_start_for_it_and_else_beside_the_first(offline):
    second = OfflineRobot(offline, offline.add_robot("telex_b", robot_description()))
    assert place(second) == (0.0, 1.3)
    change(offline, TWO)
    assert place(second) == (-0.5, -2.0)
    second.drive(0.4, 0.0)
    offline.run(0.5)
    assert place(second) != (-0.5, -2.0)
    offline.simulation.reset()
    assert place(second) == (-0.5, -2.0)
    shoulder = offline.simulation.config.start.poses["drive"]["shoulder_joint"]
    offline.run(0.1)
    assert second.positions["shoulder_joint"] == pytest.approx(shoulder, abs=0.01)
    change(offline, "objects: []\n")
    assert place(second) == (0.0, 1.3)


def test_each_obeys_its_own_commands(offline):
    first = OfflineRobot(offline)
    second = OfflineRobot(offline, offline.add_robot("telex_b", robot_description()))
    before = place(first)
    second.drive(0.4, 0.0)
    second.move({"turret_joint": 0.2})
    offline.run(0.5)
    assert place(first) == before
    assert place(second)[0] > 0.05
    assert second.positions["turret_joint"] > 0.05 > abs(first.positions["turret_joint"])


def test_a_scene_whose_starts_leave_no_room_is_refused(offline, tmp_path):
    offline.add_robot("telex_b", robot_description())
    with pytest.raises(SceneError, match="robot 'telex_b' would stand in robot 'telex'"):
        change(offline, "robots: [{x: 0.1}]\nobjects: []\n")
    path = tmp_path / "close.yaml"
    path.write_text("robots: [{x: 0.1}]\nobjects: []\n")
    with pytest.raises(Exception, match="it would stand in robot 'telex'"):
        place_robot(path, robot_description())


def test_a_pose_that_there_is_not_is_refused_by_its_place_in_the_file(offline):
    with pytest.raises(SceneError, match=r"robots\[0\]/pose is 'handstand'; there are: .*ready"):
        change(offline, "robots: [{x: 1.5, pose: handstand}]\nobjects: []\n")
