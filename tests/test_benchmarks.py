"""The benchmarks still fit what they measure."""

from __future__ import annotations

import importlib.machinery
import importlib.util
import math
import os
import subprocess
import sys
from pathlib import Path
from unittest import mock

import cv2
import numpy as np
import pytest

from telex_control.manager.controller import ControllerState
from telex_experiments.cameras import renderer
from telex_experiments.cameras.live import PictureClient, difference
from telex_experiments.rigs.thread_times import ThreadTimes
from telex_sim.scene.addresses import resolve_address

BENCHMARKS = Path(__file__).resolve().parents[1] / "benchmarks"
FOREVER = 300.0
"""Longer than any program takes that these tests wait for (s)."""


def load(name):
    loader = importlib.machinery.SourceFileLoader(f"benchmark_{name}", str(BENCHMARKS / name))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(loader.name, loader))
    loader.exec_module(module)
    return module


def test_the_control_benchmark_runs_all_shipped_controllers():
    control = load("control")
    urdf, params = control.shipped()
    names = control.controllers_of(params)
    loop = control.local(urdf, params)
    for _ in range(100):
        loop.cycle()
    listed = loop.manager.list_controllers()
    running = [info.name for info, state in listed if state is ControllerState.RUNNING]
    assert sorted(running) == sorted(names)
    assert len(names) > 20


def test_a_gap_without_a_clock_is_not_a_number(monkeypatch):
    scene = load("scene")
    now = [0.0]
    monkeypatch.setattr(scene.time, "sleep", lambda seconds: None)
    monkeypatch.setattr(scene.time, "monotonic", lambda: now[0])
    parameters = {"/telex/simulator/publish/clock_rate": 100.0}
    with mock.patch.object(scene, "rospy") as rospy:
        rospy.get_param.side_effect = lambda name: parameters.get(name, 0.001)
        gaps = scene.Gaps()
        (_, _, on_clock), _ = rospy.Subscriber.call_args

        def clocks(*times):
            for now[0] in times:
                on_clock(None)

        clocks(1.0)
        assert math.isnan(gaps.during(lambda: None))
        assert math.isclose(gaps.during(lambda: clocks(1.01, 1.06, 1.07)), 0.041)
        assert math.isclose(gaps.during(lambda: (clocks(1.08), now.__setitem__(0, 1.38))), 0.291)
    missed = scene.Figure("gap", math.nan, "ms", at_most=math.nan)
    assert not missed.ok


def test_thread_times_tell_what_each_thread_did_since_the_last_look(tmp_path):
    times = ThreadTimes(str(tmp_path))

    def write(ticks, *threads):
        process = tmp_path / "7"
        (process / "task").mkdir(parents=True, exist_ok=True)
        (process / "stat").write_text(f"7 (a ) b) S {' '.join('0' * 10)} {ticks} 0 0")
        for number, (ran, waited) in enumerate(threads, 7):
            task = process / "task" / str(number)
            task.mkdir(exist_ok=True)
            (task / "comm").write_text(f"thread{number}\n")
            (task / "schedstat").write_text(f"{ran} {waited} 1\n")

    (tmp_path / "version").mkdir()
    write(100, (9_000_000_000, 9_000_000_000))
    times.look()
    assert "ran" not in times.table()
    write(101, (9_010_000_000, 9_500_000_000), (20_000_000, 0))
    times.look()
    (tmp_path / "7" / "task" / "8" / "schedstat").unlink()
    times.look()
    told = [line.strip() for line in times.table().splitlines() if "ran" in line]
    assert told == [
        "ran    10 ms, waited   500 ms: a ) b 7, thread7 7",
        "ran    20 ms, waited     0 ms: a ) b 7, thread8 8",
    ]


def test_the_recorded_scene_can_still_be_drawn():
    recording = renderer.hall()
    assert recording.frames_in_world.shape == (len(recording.scene.frames), 4, 4)
    meshes = {visual.mesh for visual in recording.scene.visuals if visual.mesh}
    assert len(meshes) > 20
    lost = [m for m in meshes if not Path(resolve_address(m, renderer.package_path)).is_file()]
    assert not lost, "record anew: telex_experiments.cameras.renderer.record()"
    for name in renderer.NAMES:
        assert 0.0 < recording.camera(name)[2, 3] < 3.0


def test_the_recorded_scene_is_drawn_where_there_is_neither_ros_nor_a_workspace():
    """As docs/engineer/cameras.md tells for a machine that has a graphics card and nothing else."""
    names = ("telex_control", "telex_sim", "telex_training", "telex_experiments")
    src = BENCHMARKS.parent / "src"
    script = (
        "import sys\n"
        "for name in ('rospy', 'roslib', 'genpy', 'std_msgs', 'sensor_msgs', 'telex_msgs'):\n"
        "    sys.modules[name] = None\n"
        "from telex_experiments.cameras import radiation, renderer\n"
        "print(len(renderer.RobotViews(renderer.NAMES, renderer.SMALL)))\n"
    )
    kept = {name: os.environ[name] for name in ("HOME", "PATH")}
    done = subprocess.run(
        [sys.executable, "-c", script],
        env={
            **kept,
            "ROS_PACKAGE_PATH": str(src),
            "PYTHONPATH": os.pathsep.join(str(src / name / "src") for name in names),
        },
        stdout=subprocess.PIPE,
        text=True,
        check=True,
        timeout=FOREVER,
    )
    assert done.stdout.split()[-1] == "6"


class TestPictures:
    def test_one_of_another_size_is_compared_by_what_it_shows(self):
        rows, columns = np.mgrid[0:480, 0:640].astype(np.float32) * 0.3
        large = rows + columns
        small = cv2.resize(large, (240, 180), interpolation=cv2.INTER_AREA)
        assert difference(large, small) == pytest.approx(0.0, abs=0.1)
        assert difference(small, large + 5.0) == pytest.approx(5.0, abs=0.1)

    def test_those_of_several_sizes_are_not_at_rest(self):
        large, small = np.zeros((480, 640), np.float32), np.zeros((180, 240), np.float32)
        client = object.__new__(PictureClient)
        for shown, unrest in (([large, large, small, small], math.inf), ([small] * 4, 0.0)):
            client.next = iter((0.0, each) for each in shown).__next__
            assert client.unrest()[0] == unrest
