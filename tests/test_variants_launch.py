"""The same launch files drive variants of the robot that lack joints."""

from __future__ import annotations

import os
import re
import signal
import subprocess

import pytest
import yaml
from waiting import wait_until

from telex_experiments.rigs.private_master import PrivateMaster, end_tree

START = 300.0  # s; as in the tests of run.sh
FINGERS = {
    f"{side}_finger_{part}" for side in ("left", "right") for part in ("base", "middle", "tip")
}
CONTROLLERS = 22
NO_JOINTS = "none of the joints of this node"
PERIOD = 0.5
"""Time (s) between two looks, each of which starts a program."""


def ask(environment, *command):
    """Return what a program prints, nothing where it fails; one that hangs may be asked again."""
    try:
        done = subprocess.run(
            command, env=environment, capture_output=True, text=True, timeout=60.0, check=False
        )
    except subprocess.TimeoutExpired as error:
        raise LookupError(f"no answer: {error}") from error
    return done.stdout if done.returncode == 0 else ""


def pid_of(environment, node):
    """Process id of a node that answers, else None."""
    said = re.search(r"^Pid: (\d+)$", ask(environment, "rosnode", "info", node), re.MULTILINE)
    return int(said.group(1)) if said else None


def becomes(condition, what, output):
    """Wait for a condition; where it does not come, tell what roslaunch said meanwhile."""
    return wait_until(
        condition, lambda: f"{what}:\n{output.read_text(errors='replace')}", START, PERIOD
    )


def running(environment):
    service = "/telex/controller_manager/list_controllers"
    answer = yaml.safe_load(ask(environment, "rosservice", "call", service) or "{}")
    return {each["name"] for each in answer.get("controller", []) if each["state"] == "running"}


def gripper_status(environment):
    return ask(environment, "rostopic", "echo", "-n", "1", "/telex/gripper_teleop/status")


@pytest.mark.ros
@pytest.mark.waiting
def test_a_variant_comes_up_with_what_it_has(tmp_path):
    output = tmp_path / "output.txt"
    with PrivateMaster() as master, open(output, "w") as file:
        environment = master.environment()
        launch = subprocess.Popen(
            [
                *("roslaunch", "--screen", "telex_teleop", "bringup.launch"),
                *("variant:=six_axis", "cameras:=false", "console:=false"),
            ],
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=file,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            expected = CONTROLLERS - 1

            def found_all():
                assert launch.poll() is None, output.read_text(errors="replace")
                found = running(environment)
                return len(found) >= expected and found

            found = wait_until(found_all, f"{expected} controllers", START, PERIOD)
            status = gripper_status(environment)
        finally:
            end_tree(launch)
    said = output.read_text(encoding="utf-8", errors="replace")
    assert len(found) == expected, said
    left_out = "telescope_position_controller"
    assert left_out not in found
    assert f"Left out: {left_out}, for this robot has no telescope_joint" in said
    assert NO_JOINTS not in status
    assert "Traceback" not in said
    assert "ERROR" not in said


@pytest.mark.ros
@pytest.mark.waiting
def test_groups_are_switched_without_a_gripper_and_a_killed_spawner_comes_back(tmp_path):
    output = tmp_path / "output.txt"
    with PrivateMaster() as master, open(output, "w") as file:
        # What has just started may crash here, too; and what it said is looked for while it runs.
        environment = master.environment(RESTART_LEAST_RUN="1", PYTHONUNBUFFERED="1")
        launch = subprocess.Popen(
            [
                *("roslaunch", "--screen", "telex_teleop", "bringup.launch"),
                *("options:=tool=none", "cameras:=false", "console:=false"),
                "global_description:=false",
            ],
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=file,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        expected = CONTROLLERS - len(FINGERS)
        spawner, simulator = "/telex/controller_spawner", "/telex/simulator"
        try:
            becomes(lambda: len(running(environment)) == expected, "no controllers", output)
            manual = running(environment)
            assert NO_JOINTS in gripper_status(environment)
            assert ask(environment, "rosparam", "get", "/robot_description") == ""
            group = ["rosrun", "telex_control", "controller_group", "switch"]
            namespace = "__ns:=/telex"
            said = ask(environment, *group, "actions", namespace)
            assert "Left out: 'gripper_controller'" in said
            assert "arm_trajectory_controller" in running(environment)
            assert "turret_position_controller" not in running(environment)
            assert "Started" in ask(environment, *group, "manual", namespace)
            assert running(environment) == manual

            was = becomes(lambda: pid_of(environment, spawner), "no spawner", output)
            os.kill(was, signal.SIGKILL)
            becomes(lambda: pid_of(environment, spawner) not in (None, was), "no spawner", output)
            becomes(lambda: "Loaded already" in output.read_text(), "not taken over", output)
            assert running(environment) == manual
            was = becomes(lambda: pid_of(environment, simulator), "no simulator", output)
            os.kill(was, signal.SIGKILL)
            becomes(
                lambda: pid_of(environment, simulator) not in (None, was), "no simulator", output
            )
            becomes(
                lambda: running(environment) == manual, "the controllers did not come back", output
            )
        finally:
            end_tree(launch)
    said = output.read_text(encoding="utf-8", errors="replace")
    for finger in FINGERS:
        left_out = f"{finger}_position_controller"
        assert f"Left out: {left_out}, for this robot has no {finger}_joint" in said
    assert "Traceback" not in said
    assert "Failed to" not in said
