"""A robot in scenes with sources: rates, doses, cameras that die, and scenes without sources."""

import logging
import math

import numpy as np
import pytest

from telex_control.common.geometry.matrices import rotation_matrix
from telex_control.common.params import ConfigError
from telex_sim.engine.exposure import Exposure, dead_joints
from telex_sim.offline.robot import OfflineRobot
from telex_sim.offline.simulation import OfflineSimulation, robot_description
from telex_sim.radiation.dosimetry import Collimator
from telex_sim.radiation.nuclides import NUCLIDES, attenuation
from telex_sim.scene.files.scene_file import SceneError
from telex_sim.scene.robot_in_scene import robot_description as variant_description

pytestmark = pytest.mark.slow

ACTIVITY = 3.7e13
SCENE = f"""
name: hot
objects:
  - {{type: source_capsule, name: capsule, position: [3.0, 0.0, 0.0], activity: {ACTIVITY}}}
"""
CAMERAS = {
    "front": {"frame": "front_camera_optical_frame"},
    "gripper": {"frame": "gripper_camera_optical_frame"},
    "ghost": {"frame": "no_such_link"},
}
MU = attenuation("concrete", NUCLIDES["Co-60"].energy)


def unshielded(distance):
    return NUCLIDES["Co-60"].kerma_constant * ACTIVITY * 3600.0 / distance**2


@pytest.fixture(scope="module")
def urdf():
    return robot_description()


@pytest.fixture
def started(urdf):
    """Starts a scene."""
    opened = []

    def start(scene, **changes):
        offline = OfflineSimulation(urdf, world=scene, **changes)
        opened.append(offline.simulation)
        return offline

    yield start
    for simulation in opened:
        simulation.close()


def exposed(simulation):
    return Exposure(simulation.robots[0], lambda: CAMERAS)


class TestScene:
    def test_rates_are_those_of_the_links_places(self, started):
        simulation = started(SCENE).simulation
        readings = exposed(simulation).observe(simulation)
        source = np.array([3.0, 0.0, 0.045])
        for found, link in (
            (readings.hull_rate, "base_link"),
            (readings.tool_rate, "tool_link"),
            (readings.cameras[0].dose_rate, "front_camera_optical_frame"),
            (readings.cameras[1].dose_rate, "gripper_camera_optical_frame"),
        ):
            distance = np.linalg.norm(np.array(simulation.body.pose(link)[0]) - source)
            assert found == pytest.approx(unshielded(distance), rel=1e-3)
        assert [camera.name for camera in readings.cameras] == ["front", "gripper"]
        assert readings.alarm

    def test_walls_shield_by_their_entry(self, started):
        wall = "  - {type: wall, name: wall, position: [2.0, 0, 0], yaw: 1.5708, length: 4.0"
        simulation = started(SCENE + wall + ", shield: concrete}\n").simulation
        wall = simulation.objects.objects()[1].model.links[0].parts[0].geometry.size
        point = np.array([[0.5, 0.0, 0.045]])
        found = float(simulation.radiation.rates(point)[0])
        assert found == pytest.approx(unshielded(2.5) * math.exp(-MU * min(wall)), rel=1e-4)

    def test_the_field_moves_with_its_bodies(self, started):
        moving = SCENE.replace("[3.0, 0.0, 0.0]", "[3.0, 0.0, 1.0]")
        offline = started(moving)
        simulation = offline.simulation
        point = np.array([[3.0, 0.0, 2.045]])
        assert simulation.radiation.rates(point) == pytest.approx([unshielded(1.0)], rel=1e-4)
        offline.run(1.5)
        lying = float(simulation.radiation.rates(point)[0])
        assert lying == pytest.approx(unshielded(2.0), rel=0.05)

    def test_the_pot_shields_more_with_its_lid_and_evenly_all_around(self, started):
        pot = "  - {type: source_container, name: pot, position: [3.0, 0.0, 0.0], lid: LID}\n"
        # In the middle of the hole, above the bottom.
        capsule = SCENE.replace("[3.0, 0.0, 0.0]", "[3.0, 0.0, 0.06]")
        around = [(3.0 + math.cos(a), math.sin(a), 0.1) for a in np.linspace(0.0, 6.2, 40)]
        above = (3.0, 0.0, 1.4)
        open_pot = started(capsule + pot.replace("LID", "none")).simulation.radiation
        closed = started(capsule + pot.replace("LID", "free")).simulation.radiation
        beside = open_pot.rates(np.array(around))
        lead = attenuation("lead", NUCLIDES["Co-60"].energy)
        # Of boxes around the hole, which are thicker across their edges.
        assert beside.max() <= unshielded(1.0) * math.exp(-lead * 0.06)
        assert beside.min() >= 0.5 * beside.max()
        # Lid and plug.
        assert float(closed.rates(np.array([above]))[0]) == pytest.approx(
            float(open_pot.rates(np.array([above]))[0]) * math.exp(-lead * 0.055), rel=0.02
        )

    def test_nothing_is_told_without_sources(self, started):
        simulation = started("name: calm\nobjects: []\n").simulation
        assert simulation.radiation is None
        assert exposed(simulation).observe(simulation) is None

    def test_spawned_sources_count_and_deleted_ones_no_more(self, started):
        simulation = started("name: calm\nobjects: []\n").simulation
        exposure = exposed(simulation)
        assert exposure.observe(simulation) is None
        simulation.spawn(
            simulation.plan(f"{{type: source_capsule, position: [3, 0, 0], activity: {ACTIVITY}}}")
        )
        assert exposure.observe(simulation).hull_rate > 1.0
        simulation.delete("source_capsule_1")
        assert exposure.observe(simulation).hull_rate == 0.0


class TestExposure:
    def test_doses_grow_and_a_reset_sets_them_back_to_the_history(self, started):
        offline = started(SCENE + "history: {gripper: 40, robot: 0.5}\n")
        simulation, exposure = offline.simulation, exposed(offline.simulation)
        exposure.observe(simulation)
        for _ in range(10):
            offline.run(0.1)
            later = exposure.observe(simulation)
        assert later.total == pytest.approx(0.5 + later.hull_rate / 3600.0, rel=1e-4)
        gripper = later.cameras[1]
        assert gripper.dose == pytest.approx(40.0 + gripper.dose_rate / 3600.0, rel=1e-6)
        simulation.reset()
        again = exposure.observe(simulation)
        assert (again.total, again.cameras[0].dose, again.cameras[1].dose) == (0.5, 0.0, 40.0)

    def test_a_bookmark_brings_doses_back(self, started):
        offline = started(SCENE + "history: {front: 10, gripper: 120}\n")
        simulation, exposure = offline.simulation, exposed(offline.simulation)
        simulation.robots[0].watchers = (exposure,)
        exposure.observe(simulation)
        offline.run(0.5)
        before = exposure.observe(simulation)
        saved = simulation.save_state()
        offline.run(1.0)
        assert exposure.observe(simulation).total > before.total
        for spoil in (lambda: offline.run(0.1), simulation.reset):
            spoil()
            simulation.restore_state(saved)
            assert exposure.observe(simulation) == before
        # What is received from then on comes to it: nothing of the time in between.
        offline.run(1.0)
        later = exposure.observe(simulation)
        assert later.total == pytest.approx(before.total + later.hull_rate / 3600.0, rel=1e-3)

    def test_a_bookmark_of_before_the_first_look_begins_with_the_history(self, started):
        offline = started(SCENE + "history: {robot: 0.5}\n")
        simulation, exposure = offline.simulation, exposed(offline.simulation)
        simulation.robots[0].watchers = (exposure,)
        saved = simulation.save_state()
        exposure.observe(simulation)
        offline.run(1.0)
        exposure.observe(simulation)
        simulation.restore_state(saved)
        assert exposure.observe(simulation).total == 0.5

    def test_a_camera_dies_of_its_dose_alone_and_is_new_in_another_scene(self, started, caplog):
        offline = started(SCENE + "history: {gripper: 120}\n")
        simulation, exposure = offline.simulation, exposed(offline.simulation)
        with caplog.at_level(logging.WARNING, "rosout"):
            for _ in range(3):
                readings = exposure.observe(simulation)
        assert [camera.failed for camera in readings.cameras] == [False, True]
        assert caplog.text.count("camera gripper has died, of 120.0 Gy") == 1
        simulation.change_scene(simulation.plan_scene("name: calm\nobjects: []\n"))
        calm = exposure.observe(simulation)
        assert [(camera.dose, camera.failed) for camera in calm.cameras] == [(0.0, False)] * 2
        assert not calm.alarm
        assert exposure.observe(simulation) is None

    def test_electronics_die_of_their_dose_and_brakes_hold_until_a_reset(self, started, caplog):
        offline = started(SCENE + "history: {drive_electronics: 395, arm_electronics: 0}\n")
        simulation, exposure = offline.simulation, exposed(offline.simulation)
        with caplog.at_level(logging.WARNING, "rosout"):
            readings = exposure.observe(simulation)
        assert [(part.name, part.failed) for part in readings.electronics] == [
            ("drive_electronics", True),
            ("arm_electronics", False),
        ]
        assert caplog.text.count("electronics drive_electronics has died, of 395.0 Gy") == 1
        joints = dead_joints(readings, simulation.robots[0].config.dosimetry)
        assert "front_left_track_joint" in joints
        assert "turret_joint" not in joints

        def driven():
            robot = OfflineRobot(offline)
            before = robot.base_pose()[0][0]
            for _ in range(5):
                robot.drive(0.5, 0.0)
                offline.run(0.1)
            return robot.base_pose()[0][0] - before

        assert abs(driven()) < 0.005
        simulation.change_scene(simulation.plan_scene("name: calm\nobjects: []\n"))
        assert exposure.observe(simulation).electronics[0].failed is False
        assert driven() > 0.05

    def test_electronics_with_the_name_of_a_camera_are_left_out(self, started, caplog):
        same = {
            "front": {"link": "base_link", "joints": ["turret_joint"], "life": 1.0},
            "ghost": {"link": "base_link", "joints": ["turret_joint"]},
        }
        simulation = started(
            SCENE + "history: {front: 20}\n", dosimetry__electronics=same
        ).simulation
        with caplog.at_level(logging.WARNING, "rosout"):
            readings = exposed(simulation).observe(simulation)
        assert [(part.name, part.failed) for part in readings.cameras] == [
            ("front", False),
            ("gripper", False),
        ]
        assert [part.name for part in readings.electronics] == ["ghost"]
        assert readings.electronics[0].dose_rate == readings.hull_rate
        assert readings.tool_rate > 0.0
        assert caplog.text.count("electronics 'front' of telex are left out; camera 'front'") == 1

    def test_names_a_history_of_what_is_not_there(self, started, caplog):
        simulation = started("name: old\nobjects: []\nhistory: {nose: 3}\n").simulation
        with caplog.at_level(logging.WARNING, "rosout"):
            readings = exposed(simulation).observe(simulation)
        assert "history has nose, which this robot lacks; it has robot, front" in caplog.text
        assert readings.total == 0.0

    def test_cameras_that_nobody_describes_are_left_out(self, started):
        simulation = started(SCENE).simulation
        for described in ({}, None, "front", {"front": 3}, {"front": {"frame": 4}}):
            exposure = Exposure(simulation.robots[0], lambda described=described: described)
            assert exposure.observe(simulation).cameras == ()


class TestDetector:
    def test_it_sees_what_it_points_at_and_is_read_without_sources(self, started):
        probe = variant_description("inspection")
        offline = OfflineSimulation(probe, world="name: calm\nobjects: []\n")
        simulation, exposure = offline.simulation, exposed(offline.simulation)
        try:
            calm = exposure.observe(simulation)
            assert (calm.tool_rate, calm.detector) == (0.0, "detector_link")
            position, orientation = simulation.body.pose("detector_link")
            axis = rotation_matrix(orientation)[:, 0]
            rates = []
            for sign in (1.0, -1.0):
                place = np.array(position) + sign * 2.0 * axis
                simulation.spawn(
                    simulation.plan(
                        "{type: custom, name: source, static: true, position: "
                        f"{place.tolist()}, links: [{{name: a, source: {{nuclide: Co-60, "
                        f"activity: {ACTIVITY}}}, parts: [{{sphere: 0.01, solid: false}}]}}]}}"
                    )
                )
                rates.append(exposure.observe(simulation).tool_rate)
                simulation.delete("source")
            assert rates[0] == pytest.approx(unshielded(2.0), rel=1e-6)
            assert rates[1] == pytest.approx(0.05 * unshielded(2.0), rel=1e-6)
        finally:
            simulation.close()

    def test_half_counts_at_the_half_angle(self):
        shield = Collimator(0.3, 0.1)
        ways = np.array([[np.cos(a), np.sin(a), 0.0] for a in (0.0, 0.3, 1.2, np.pi)])
        found = shield.response(2.0 * ways, np.array([1.0, 0.0, 0.0]))
        assert found == pytest.approx([1.0, 0.55, 0.1 + 0.9 * 2.0**-16, 0.1], rel=1e-6)


class TestFiles:
    @pytest.mark.parametrize(
        ("entry", "message"),
        [
            ("{type: wall, shield: gold}", "shield is 'gold'"),
            ("{type: source_capsule, nuclide: U-235, activity: 1}", "nuclide is 'U-235'"),
            ("{type: source_capsule, activity: .nan}", "activity is nan"),
            ("{type: source_capsule, activity: 1.0e20}", r"activity is 1e\+20"),
            (
                "{type: custom, static: true, shield: lead, links: [{name: a, parts: "
                "[{mesh: 'package://telex_sim/meshes/tube.obj'}]}]}",
                "shield is 'lead'; the object has a solid mesh",
            ),
        ],
    )
    def test_refuse_what_makes_no_sense(self, started, entry, message):
        with pytest.raises((ConfigError, SceneError), match=message):
            started(f"name: wrong\nobjects:\n  - {entry}\n")

    def test_any_entry_carries_a_source(self, started):
        given = f"source: {{nuclide: Co-60, activity: {ACTIVITY}}}"
        field = started(
            f"name: hot\nobjects:\n  - {{type: cube, edge: 0.1, position: [3, 0, 0], {given}}}\n"
        ).simulation.radiation
        found = float(field.rates(np.array([[1.0, 0.0, 0.05]]))[0])
        assert found == pytest.approx(unshielded(2.0), rel=1e-4)

    def test_custom_objects_carry_sources_and_shields(self, started):
        field = started(
            f"""
name: custom
objects:
  - type: custom
    position: [3, 0, 0]
    links:
      - name: body
        mass: 5
        source: {{nuclide: Co-60, activity: {ACTIVITY}, position: [0, 0, 0.2]}}
        parts:
          - {{box: [0.2, 0.2, 0.1], position: [0, 0, 0.05]}}
          - {{box: [0.1, 2.0, 2.0], position: [-0.5, 0, 1.2], shield: concrete, solid: false}}
"""
        ).simulation.radiation
        found = float(field.rates(np.array([[1.0, 0.0, 0.2]]))[0])
        assert found == pytest.approx(unshielded(2.0) * math.exp(-MU * 0.1), rel=1e-4)
