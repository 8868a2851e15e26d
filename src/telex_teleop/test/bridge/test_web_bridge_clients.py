"""The bridge before the clients of other makes that it is for: roslibpy, and roslib of npm."""

from __future__ import annotations

import importlib.util
import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest
from waiting import wait_until
from web_harness import START, Ros

pytestmark = [pytest.mark.ros, pytest.mark.waiting]

CLIENTS = Path(__file__).parents[1].joinpath("bridge_clients")
SUCCEEDED = 3
POSITIONS = [0.5, -1.25e-7, None]
SWITCHED = {"success": True, "message": "on"}


@pytest.fixture(scope="module")
def ros():
    with Ros() as ros:
        yield ros


@pytest.fixture(scope="module")
def outcomes(ros):
    """What each client did; all of them at the same time, on one bridge."""
    probe = ros.probe()
    # Long, because a loaded machine takes its time to connect nodes; it is not waited out.
    ros.master.setParam("/telex/rosbridge/connect_timeout", 10.0)
    _, url = ros.serve("rosbridge", None, "_plain:=true")
    port = url.rpartition(":")[2]
    probe.do("serve", service="/lamp", type="std_srvs/SetBool", response=SWITCHED)
    ros.start_node("transforms")
    frames = [("odom", "base_link", {"x": 1.0}), ("base_link", "arm", {"z": 0.5})]
    tree = [
        {
            "header": {"frame_id": parent},
            "child_frame_id": child,
            "transform": {"translation": place, "rotation": {"w": 1.0}},
        }
        for parent, child, place in frames
    ]
    probe.publish("/tf", "tf2_msgs/TFMessage", {"transforms": tree}, rate=20)
    wait_until(lambda: ros.publishers("/tf2_web_republisher/status"), timeout=START)
    states = {"header": {"frame_id": "x"}, "name": ["turret_joint", "ärmchen"]}
    states["position"] = [float("nan") if each is None else each for each in POSITIONS]
    probe.publish("/compressible", "sensor_msgs/JointState", states, rate=20)
    commands = {}
    if importlib.util.find_spec("roslibpy"):
        script = str(CLIENTS / "roslibpy_client.py")
        commands["roslibpy_twisted"] = [sys.executable, script, port, "roslibpy_twisted"]
        commands["roslibpy_asyncio"] = [sys.executable, script, port, "roslibpy_asyncio"]
    if shutil.which("node") and (CLIENTS / "node_modules").is_dir():
        for generation in "12":
            script = str(CLIENTS / "roslib_client.mjs")
            commands[f"roslib_{generation}"] = ["node", script, generation, url]
    running = {}
    for name, command in commands.items():
        probe.do("act", server=f"/{name}/flippers")
        transport = {"ROSLIBPY_TRANSPORT": name.rpartition("_")[2]} if "libpy" in name else {}
        running[name] = subprocess.Popen(
            command,
            env={**os.environ, **transport},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
    outcomes, end = {}, time.monotonic() + 90.0
    for name, process in running.items():
        try:
            said, complaints = process.communicate(timeout=max(0.1, end - time.monotonic()))
        except subprocess.TimeoutExpired:
            process.kill()
            said, complaints = process.communicate()
        outcomes[name] = (process.returncode, said, complaints)
    return outcomes


def outcome_of(outcomes, name, remedy):
    if name not in outcomes:
        pytest.skip(remedy)
    status, said, complaints = outcomes[name]
    assert status == 0, complaints
    assert "Traceback" not in complaints
    return json.loads(said.splitlines()[-1])


@pytest.mark.parametrize("transport", ["twisted", "asyncio"])
def test_roslibpy(outcomes, transport):
    name = f"roslibpy_{transport}"
    outcome = outcome_of(outcomes, name, "roslibpy is not installed")
    graph = outcome.pop("graph")
    # Other clients offer services of this type meanwhile.
    assert "/lamp" in graph.pop("services_for_type")
    assert graph == {
        "topic": True,
        "topic_type": "telex_msgs/BridgeClients",
        "topics_for_type": ["/telex/bridge/clients"],
        "service": True,
        "service_type": "std_srvs/SetBool",
        "node": True,
        "publishing": True,
        "request": ["data"],
        "response": ["bool", "string"],
        "message": ["geometry_msgs/Twist", "geometry_msgs/Vector3"],
        "time": True,
    }
    assert outcome == {
        "topic": ["one", "two", "three"],
        "service": [SWITCHED, "there is no service /no_lamp"],
        "offered_service": {"success": True, "message": name},
        "parameter": [{"speed": 1.5}, None],
        "action": [True, f"did {name}", SUCCEEDED],
        "action_server": "did high",
    }


@pytest.mark.parametrize("generation", ["1", "2"])
def test_roslib(outcomes, generation):
    name = f"roslib_{generation}"
    outcome = outcome_of(outcomes, name, "npm's roslib is not installed: launch_scripts/setup.sh")
    graph = outcome.pop("graph")
    assert "/lamp" in graph.pop("services_for_type")
    assert graph == {
        "topic_type": "telex_msgs/BridgeClients",
        "topics_for_type": ["/telex/bridge/clients"],
        "service": True,
        "service_type": "std_srvs/SetBool",
        "node": True,
        "request": ["data"],
        "twist": ["linear", "angular"],
        "raw": True,
        "parameter": True,
        "action_server": True,
    }
    assert outcome == {
        "topic": ["one", "two", "three"],
        "service": [SWITCHED, "there is no service /no_lamp"],
        "offeredService": {"success": True, "message": name},
        "hurriedService": 10,
        "compressed": {
            way: [["turret_joint", "ärmchen"], POSITIONS, "x"] for way in ("png", "cbor")
        },
        # It stands still, so that it is told once.
        "transforms": [[1.0, 0.5, 1]] * (2 if generation == "1" else 1),
        "parameter": [{"speed": 1.5}, None],
        "action": [True, f"did {name}"],
    }
