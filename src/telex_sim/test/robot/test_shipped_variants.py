"""Every shipped variant of the robot stands in every pose, drives, and has stable joints."""

from __future__ import annotations

import subprocess
import sys

import pytest
import yaml
from geometry_msgs.msg import Twist

from telex_control.common.file_catalog import package_file
from telex_sim.engine.world import WorldError
from telex_sim.offline.simulation import OfflineSimulation

pytestmark = pytest.mark.slow

SCRIPT = package_file("telex_description", "scripts", "robot_description")
with open(package_file("telex_description", "config", "variants.yaml")) as file:
    VARIANTS = list(yaml.safe_load(file)["variants"])
POSES = ("stow", "drive", "ready", "look_front", "floor_pick")
# The inspection probe reaches 135 mm further than the gripper, for which the pose was made.
IN_THE_FLOOR = {("inspection", "floor_pick")}


def description(*arguments):
    return subprocess.run(
        [sys.executable, str(SCRIPT), *arguments], check=True, capture_output=True, text=True
    ).stdout


@pytest.fixture(scope="module")
def descriptions():
    return {name: description(name) for name in VARIANTS}


@pytest.fixture
def simulated():
    made = []

    def make(urdf, **changes):
        made.append(OfflineSimulation(urdf, **changes))
        return made[-1]

    yield make
    for each in made:
        each.simulation.close()


@pytest.mark.parametrize("pose", POSES)
@pytest.mark.parametrize("name", VARIANTS)
def test_it_holds_every_pose(descriptions, simulated, name, pose):
    if (name, pose) in IN_THE_FLOOR:
        with pytest.raises(WorldError, match=r"'floor_pick'.* probe_link stands .* in the floor"):
            simulated(descriptions[name], start__pose=pose)
        return
    tested = simulated(descriptions[name], start__pose=pose)
    wanted = tested.simulation.config.start.joint_positions()
    tested.run(0.3)
    for joint, position in tested.positions().items():
        if "track" not in joint:
            assert position == pytest.approx(wanted[joint], abs=5e-3), joint


@pytest.mark.parametrize("name", VARIANTS)
def test_it_drives(descriptions, simulated, name):
    tested = simulated(descriptions[name])
    tested.run(0.5)
    (start, _, _), _ = tested.simulation.body.base_pose()
    command = Twist()
    command.linear.x = 0.3
    publisher = tested.node.advertise("/track_controller/cmd_vel", Twist)
    for _ in range(20):
        publisher.publish(command)
        tested.run(0.1)
    (end, _, _), _ = tested.simulation.body.base_pose()
    assert end - start == pytest.approx(0.6, abs=0.09)


def test_a_payload_in_the_turret_is_refused(simulated):
    urdf = description("payload_mass:=10", "payload_xyz:=0.1 0 0.25")
    with pytest.raises(WorldError, match=r"'ready'.*deep in its (payload_link|turret_link)"):
        simulated(urdf)
