"""The same launch files drive variants of the robot that lack joints."""

from __future__ import annotations

import subprocess
import time

import pytest
import yaml

from telex_control.private_master import PrivateMaster, end_tree

START = 60.0  # s
FINGERS = {
    f"{side}_finger_{part}" for side in ("left", "right") for part in ("base", "middle", "tip")
}
CONTROLLERS = 22


def ask(environment, *command):
    done = subprocess.run(
        command, env=environment, capture_output=True, text=True, timeout=20.0, check=False
    )
    return done.stdout if done.returncode == 0 else ""


def running(environment):
    service = "/telex/controller_manager/list_controllers"
    answer = yaml.safe_load(ask(environment, "rosservice", "call", service) or "{}")
    return {each["name"] for each in answer.get("controller", []) if each["state"] == "running"}


@pytest.mark.ros
@pytest.mark.parametrize(
    ("variant", "lacking", "gripper"),
    [("six_axis", {"telescope"}, True), ("carrier", FINGERS, False)],
)
def test_a_variant_comes_up_with_what_it_has(variant, lacking, gripper, tmp_path):
    output = tmp_path / "output.txt"
    with PrivateMaster() as master, open(output, "w") as file:
        environment = master.environment()
        launch = subprocess.Popen(
            [
                *("roslaunch", "--screen", "telex_teleop", "bringup.launch"),
                *(f"variant:={variant}", "cameras:=false", "console:=false"),
            ],
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=file,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            expected = CONTROLLERS - len(lacking)
            end = time.monotonic() + START
            found = set()
            while len(found) < expected and time.monotonic() < end and launch.poll() is None:
                found = running(environment)
            status = ask(environment, "rostopic", "echo", "-n", "1", "/telex/gripper_teleop/status")
        finally:
            end_tree(launch)
    said = output.read_text(encoding="utf-8", errors="replace")
    assert len(found) == expected, said
    for joint in lacking:
        assert f"{joint}_position_controller" not in found
        assert f"Left out: {joint}_position_controller, for this robot has no {joint}_joint" in said
    assert ("none of the joints of this node" in status) is not gripper
    assert "Traceback" not in said
    assert "ERROR" not in said
