"""Operators in one process with the simulation, behind the cores of the teleoperation nodes."""

from __future__ import annotations

from pathlib import Path
from typing import Iterator

import numpy as np
import pytest
import yaml

from telex_sim.offline.robot import OfflineRobot
from telex_sim.offline.simulation import OfflineSimulation, robot_description
from telex_training.operators import driving
from telex_training.operators.handling import Hand, aimed
from telex_training.operators.port import (
    Drive,
    FlipperPreset,
    Jog,
    JointTargets,
    NamedPose,
    NotManagedError,
)
from telex_training.operators.station import Keys, Station
from telex_training.operators.tasks.briefcase import Briefcase
from telex_training.rehearsal.controllers import OfflineControllers
from telex_training.rehearsal.teleop import OfflineTeleop

pytestmark = pytest.mark.slow


def simulation(folder: Path, **objects: dict) -> OfflineSimulation:
    scene = folder / "scene.yaml"
    entries = [{"name": name, **entry} for name, entry in objects.items()]
    scene.write_text(yaml.safe_dump({"objects": entries}))
    return OfflineSimulation(robot_description(), world=str(scene), start__pose="ready")


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[OfflineRobot]:
    cube = {"type": "cube", "position": [3.0, 1.0, 0.0], "edge": 0.05}
    made = simulation(tmp_path, cube=cube)
    yield OfflineRobot(made)
    made.simulation.close()


@pytest.fixture
def station(robot: OfflineRobot) -> Station:
    return Station(OfflineTeleop(robot))


class TestTeleop:
    def test_it_drives_to_a_place_and_turns(self, station: Station) -> None:
        driving.drive_to(station, (0.8, 0.3))
        assert np.hypot(station.pose.x - 0.8, station.pose.y - 0.3) < 0.05
        driving.turn_to(station, -0.5)
        assert abs(station.pose.yaw + 0.5) < 0.05
        assert station.now == pytest.approx(station.time + 0.75, abs=0.05)

    def test_a_preset_holds_while_its_key_does(self, station: Station) -> None:
        keys = Keys(station)
        before = station.joint("front_left_flipper")
        keys.hold("folded")
        keys.wait(0.6)
        keys.hold("")
        keys.wait(0.5)
        released = station.joint("front_left_flipper")
        assert abs(released - before) > 0.1
        keys.wait(0.5)
        assert station.joint("front_left_flipper") == pytest.approx(released, abs=0.01)

    def test_joints_and_tool_go_where_they_are_led(self, station: Station) -> None:
        hand = Hand(station)
        station.jog_to("arm_teleop", "turret_joint", 0.2)
        assert station.measured("turret_joint") == pytest.approx(0.2, abs=0.02)
        hand.to_named_pose("ready")
        station.mode("CARTESIAN")
        target = hand.tool() @ aimed(0.05, 0.0, 0.0)
        hand.to(target)
        assert np.linalg.norm(hand.tool()[:3, 3] - target[:3, 3]) < 0.004
        begin = hand.tool()[:3, 3]
        station.hold_tool_twist((0.0, 0.0, -0.1), frame="base_link")
        station.wait(1.0)
        station.release_arm()
        assert hand.tool()[2, 3] < begin[2] - 0.03

    def test_nodes_say_why_they_do_not_obey(self, station: Station) -> None:
        station.port.e_stop(True)
        station.drive(0.5)
        station.wait(0.4)
        assert station.notices["track_teleop"] == "the e-stop is active"
        assert abs(station.pose.x) < 0.02
        station.port.e_stop(False)
        said = set()
        station.until(
            lambda: station.pose.x > 0.3,
            4.0,
            "driving on",
            lambda: said.add(station.notices["track_teleop"]),
        )
        assert any("press it again" in notice for notice in said)

    def test_a_reset_puts_the_robot_back_at_rest(self, robot: OfflineRobot) -> None:
        port = OfflineTeleop(robot)
        station = Station(port)
        station.drive(0.5)
        station.wait(1.0)
        assert station.pose.x > 0.2
        port.reset()
        station.look()
        assert abs(station.pose.x) < 0.01
        station.rest()
        assert abs(station.pose.x) < 0.02

    def test_what_a_core_refuses_is_said_and_does_not_end_the_script(
        self, station: Station
    ) -> None:
        station.jog("gripper_teleop", elbow_joint=0.1)
        station.tick()
        assert "elbow_joint" in station.notices["gripper_teleop"]
        station.hold_named_pose("nowhere")
        station.wait(0.3)
        assert "nowhere" in station.notices["arm_teleop"]
        with pytest.raises(NotManagedError, match="mode 'SIDEWAYS' is unknown"):
            station.mode("SIDEWAYS")

    def test_objects_are_seen_and_pictures_are_not(self, station: Station) -> None:
        assert station.object_pose("cube")[:2, 3] == pytest.approx([3.0, 1.0], abs=0.01)
        with pytest.raises(NotManagedError, match="no object 'sphere'"):
            station.object_pose("sphere")
        with pytest.raises(NotManagedError, match="camera turret: a rehearsal draws no pictures"):
            station.port.camera("turret")

    def test_a_question_is_answered_where_somebody_asks(self, robot: OfflineRobot) -> None:
        given = []
        asking = OfflineTeleop(robot, on_answer=lambda *answer: given.append(answer))
        asking.answer("label", "up")
        assert given == [("label", "up")]
        with pytest.raises(NotManagedError, match="'label' cannot be answered: nobody asks"):
            OfflineTeleop(robot).answer("label", "up")

    def test_it_takes_the_commands_of_its_nodes_alone(self, robot: OfflineRobot) -> None:
        port = OfflineTeleop(robot)
        with pytest.raises(TypeError, match="JointTargets"):
            port.send(JointTargets({"elbow_joint": 0.0}))
        with pytest.raises(TypeError, match="'head_teleop'"):
            port.send(Jog("head_teleop", {"elbow_joint": 0.0}))

    def test_two_rehearsals_are_the_same_to_the_last_bit(self, tmp_path: Path) -> None:
        poses = []
        for _ in range(2):
            made = simulation(tmp_path)
            station = Station(OfflineTeleop(OfflineRobot(made)))
            station.hold("arm_teleop", NamedPose("drive"))
            station.hold("flipper_teleop", FlipperPreset("climb"))
            station.drive(0.4, 0.2)
            station.wait(1.5)
            poses.append((station.pose, station.measured("elbow_joint")))
            made.simulation.close()
        assert poses[0] == poses[1]


def test_a_briefcase_is_carried_away(tmp_path: Path) -> None:
    task = Briefcase()
    made = simulation(tmp_path, **task.lay_out(np.random.default_rng(1)))
    station = Station(OfflineTeleop(OfflineRobot(made)))
    task.begin(station)
    station.mode("CARTESIAN")
    task.act(Hand(station))
    assert station.grip.object == "briefcase"
    assert station.grip.force > 50.0
    verdict = task.judge(station)
    assert verdict.done, verdict.text
    made.simulation.close()


def test_controllers_take_no_keys(robot: OfflineRobot) -> None:
    port = OfflineControllers(robot, robot.run)
    port.send(JointTargets({"front_left_flipper_joint": 0.3}))
    port.send(Drive(0.3))
    port.advance(1.0)
    seen = port.observe()
    assert seen.positions["front_left_flipper_joint"] == pytest.approx(0.3, abs=0.02)
    assert seen.base is not None
    assert seen.base.position[0] > 0.02
    with pytest.raises(TypeError, match="FlipperPreset"):
        port.send(FlipperPreset("climb"))
