"""What comes from outside is tried in a process of its own, which ends where it takes too much."""

from __future__ import annotations

import contextlib
import os
import pickle
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path
from unittest import mock

import numpy as np
import pytest
from waiting import wait_until

from telex_control.common.params import ConfigError
from telex_control.urdf.joints import UrdfError
from telex_sim.engine.simulator_config import RobotConfig
from telex_sim.offline.simulation import shipped_config
from telex_sim.rehearsal import client as rehearsal_client
from telex_sim.rehearsal import process as rehearsal_process
from telex_sim.rehearsal.client import RehearsalClient
from telex_sim.rehearsal.frames import read_values
from telex_sim.rehearsal.process import ListingRequest, _perform, _Stage, _why_ended
from telex_sim.robot.body import RobotBody
from telex_sim.scene.catalog import PATH_VARIABLE, scenes
from telex_sim.scene.files.scene_file import SceneError
from telex_sim.scene.model import Floor, Start

pytestmark = pytest.mark.slow

HUNG = 120.0  # s; a busy machine may let these processes compute only now and then

LINK = """<link name="base"><inertial><mass value="{mass}"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
<collision><geometry>{shape}</geometry></collision></link>"""


@pytest.fixture(scope="module")
def rehearsal():
    client = RehearsalClient(shipped_config())
    yield client
    client.close()


def entry(rehearsal, text, folder=""):
    return rehearsal.entry(text, "", folder, ["crate_1"], ["telex"], Floor())


def box_robot(shape='<box size="1 1 1"/>', mass="1"):
    urdf = f'<robot name="r">{LINK.format(mass=mass, shape=shape)}</robot>'
    return RobotBody("crane", urdf, RobotConfig())


def obj(path, side):
    """A grid of side x side vertices."""
    lines = [f"v {x} {y} {0.1 * ((x * y) % 3)}" for x in range(side) for y in range(side)]
    for x in range(side - 1):
        for y in range(side - 1):
            corner = x * side + y + 1
            lines.append(f"f {corner} {corner + 1} {corner + side}")
    path.write_text("\n".join(lines))


def test_a_scene_comes_back_as_it_is_read_here(rehearsal, robot, urdf):
    simulation = robot().simulation
    figures = [each.figure for each in simulation.robots]
    for name in scenes():
        here, there = simulation.plan_scene(name), rehearsal.scene(name, figures)
        assert there.scene == here.scene
        assert there.path == here.path
        assert [repr(each) for each in there.assemblies] == [repr(each) for each in here.assemblies]


def test_an_entry_comes_back_and_is_named_as_here(rehearsal):
    (plan,) = entry(rehearsal, "{type: crate}")
    assert plan.source.name == "crate_2"


def test_a_mesh_comes_back_with_all_its_numbers(rehearsal, robot, tmp_path):
    obj(tmp_path / "hill.obj", 40)
    text = "{type: mesh, mesh: hill.obj, static: true}"
    (there,) = entry(rehearsal, text, str(tmp_path))
    (here,) = robot().simulation.plan(text, "", str(tmp_path))
    for ours, theirs in zip(here.bodies, there.bodies):
        for mine, its in zip(ours.segments[0].shapes, theirs.segments[0].shapes):
            assert np.array_equal(mine.vertices, its.vertices)
            assert np.array_equal(mine.triangles, its.triangles)


def test_what_is_wrong_is_refused_in_the_same_words(rehearsal, robot, tmp_path):
    figures = [each.figure for each in robot().simulation.robots]
    with pytest.raises(ConfigError, match="mass is -1.0; it must be above 0"):
        entry(rehearsal, "{type: crate, mass: -1}")
    with pytest.raises(ConfigError, match="name is 'telex'"):
        entry(rehearsal, "{type: crate, name: telex}")
    with pytest.raises(SceneError, match="there is no scene 'moon'"):
        rehearsal.scene("moon", figures)
    crowd = tmp_path / "crowd.yaml"
    crowd.write_text("objects:\n" + "  - {type: crate, position: [5, 0, 0]}\n" * 200)
    with pytest.raises(SceneError, match="stand in each other: 'crate_1' and 'crate_2'"):
        rehearsal.scene(str(crowd), figures)
    pillar = tmp_path / "pillar.yaml"
    pillar.write_text("objects:\n  - {type: platform, position: [0.3, 0, 0]}\n")
    with pytest.raises(SceneError, match="pillar.yaml: start pose 'ready': the robot's"):
        rehearsal.scene(str(pillar), figures)


def test_twenty_thousand_objects_are_refused_soon(rehearsal, robot, tmp_path):
    many = tmp_path / "many.yaml"
    many.write_text("objects:\n" + "  - {type: crate}\n" * 20_000)
    with pytest.raises(SceneError, match="there are more than 1000 objects"):
        rehearsal.scene(str(many), [each.figure for each in robot().simulation.robots])


def test_robots_are_tried_too(rehearsal, tmp_path):
    assert rehearsal.robot(box_robot(), Start(y=-20.0)) == []
    for mass, said in (("-5", "mass is -5"), ("nan", '<mass value="nan">')):
        with pytest.raises(UrdfError, match=f"link 'base': {said}"):
            rehearsal.robot(box_robot(mass=mass), Start())
    with pytest.raises(ConfigError, match="link 'base': .*none.stl: No such file"):
        rehearsal.robot(box_robot(f'<mesh filename="file://{tmp_path}/none.stl"/>'), Start())
    large = tmp_path / "large.obj"
    with large.open("wb") as file:
        file.truncate(104_000_000)
    with pytest.raises(ConfigError, match="has 104000000 bytes; at most 67108864 are read"):
        rehearsal.robot(box_robot(f'<mesh filename="file://{large}"/>'), Start())
    obj(tmp_path / "fine.obj", 260)
    with pytest.raises(ConfigError, match="at most 60000 are possible in a robot"):
        rehearsal.robot(box_robot(f'<mesh filename="file://{tmp_path}/fine.obj"/>'), Start())


PATIENT = """#!/bin/sh
exec "{}" -c 'from telex_sim.rehearsal import process, start
process.MOST_TIME = {}
start.main()' "$3" "$4"
"""


def test_it_ends_where_it_takes_too_long_and_the_next_is_served(monkeypatch, tmp_path):
    """A legal file that is read for longer than anybody waits."""
    # By what it computes, however long a busy machine takes to let it.
    python = tmp_path / "python"
    python.write_text(PATIENT.format(sys.executable, 10.0 * HUNG))
    python.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(python))
    monkeypatch.setattr(rehearsal_client, "MOST_TIME", 10.0 * HUNG)
    client = RehearsalClient(shipped_config())
    slow = tmp_path / "slow.obj"
    slow.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n" + "vt 0.1234 0.2345\n" * 3_500_000 + "f 1 2 3\n")
    try:
        with pytest.raises(ConfigError, match="the object .*: it took more than 2 s of computing;"):
            entry(client, f"{{type: mesh, static: true, mesh: {slow}}}")
        assert len(entry(client, "{type: crate}")) == 1
    finally:
        client.close()


def test_what_takes_too_much_memory_is_refused_and_the_next_is_served(tmp_path):
    large = tmp_path / "large.obj"
    large.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n" + "vt 0.1234 0.2345\n" * 3_500_000)
    client = RehearsalClient(shipped_config(), most_memory=160 * 1024**2)
    try:
        with pytest.raises(ConfigError, match="the object .*: it took more than 160 MB of memory"):
            entry(client, f"{{type: mesh, static: true, mesh: {large}}}")
        asked = client._process.pid
        assert len(entry(client, "{type: crate}")) == 1
        assert client._process.pid == asked
    finally:
        client.close()


def test_it_is_started_again_when_it_has_ended(rehearsal):
    process = rehearsal._process
    process.kill()
    process.wait()
    assert len(entry(rehearsal, "{type: crate}")) == 1
    assert rehearsal._process.pid != process.pid


def test_it_is_an_ordinary_process_that_steps_back(rehearsal):
    pid = rehearsal._process.pid
    assert os.sched_getscheduler(pid) == os.SCHED_OTHER
    own = os.getpriority(os.PRIO_PROCESS, 0)
    assert os.getpriority(os.PRIO_PROCESS, pid) == min(own + 5, 19)


def test_all_scenes_are_listed(rehearsal):
    listed = rehearsal.listing()
    assert [scene.name for scene in listed] == list(scenes())
    assert all(scene.description and not scene.problem for scene in listed)


def test_a_scene_that_is_listed_is_read_again_when_its_file_has_changed(tmp_path, monkeypatch):
    monkeypatch.setenv(PATH_VARIABLE, str(tmp_path))
    first, second, broken = (tmp_path / f"{name}.yaml" for name in ("a", "b", "c"))
    first.write_text("description: one\n")
    second.write_text("description: two\n")
    broken.write_text("[")
    stage = mock.Mock()

    def listing():
        with mock.patch.object(rehearsal_process, "read_description", wraps=read) as reading:
            listed = list(ListingRequest(known).answer(stage))
        known.clear()
        known.update({scene.path: scene for scene in listed})
        own = [scene for scene in listed if Path(scene.path).parent == tmp_path]
        told = [(scene.name, scene.description, bool(scene.problem)) for scene in own]
        return told, {call.args[0] for call in reading.call_args_list}

    read, known = rehearsal_process.read_description, {}
    before = [("a", "one", False), ("b", "two", False), ("c", "", True)]
    told, files = listing()
    assert told == before
    assert files >= {first, second, broken}
    assert listing() == (before, set())
    second.write_text("description: three\n")
    assert listing() == ([before[0], ("b", "three", False), before[2]], {second})
    first.unlink()
    assert listing() == ([("b", "three", False), before[2]], set())


def test_an_answer_that_cannot_be_read_does_not_spoil_the_next(rehearsal, monkeypatch):
    def broken(read):
        read(8)
        raise pickle.UnpicklingError("what is this?")

    with monkeypatch.context() as patched:
        patched.setattr(rehearsal_client, "read_values", broken)
        with pytest.raises(ConfigError, match="could not be tried: .*what is this"):
            entry(rehearsal, "{type: crate}")
    assert len(entry(rehearsal, "{type: crate}")) == 1


def test_a_process_that_cannot_be_started_is_a_mistake_that_is_told(monkeypatch):
    monkeypatch.setattr(sys, "executable", "/nowhere/python")
    with pytest.raises(ConfigError, match="cannot be started: .*/nowhere/python"):
        RehearsalClient(shipped_config())


def test_closing_does_not_wait_for_a_request():
    client = RehearsalClient(shipped_config())
    refused = []

    def ask():
        try:
            client.listing()
        except ConfigError as error:
            refused.append(str(error))

    client.listing()
    os.kill(client._process.pid, signal.SIGSTOP)
    asking = threading.Thread(target=ask)
    asking.start()
    wait_until(client._lock.locked)
    began = time.monotonic()
    client.close()
    asking.join()
    assert time.monotonic() - began < 10.0
    assert "has ended" in refused[0]


def test_what_tries_ends_with_its_process(tmp_path):
    client = RehearsalClient(shipped_config())
    client.listing()
    parent = client._process.pid
    slow = tmp_path / "slow.obj"
    slow.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n" + "vt 0.1234 0.2345\n" * 3_500_000 + "f 1 2 3\n")

    def ask():
        with contextlib.suppress(ConfigError):
            entry(client, f"{{type: mesh, static: true, mesh: {slow}}}")

    asking = threading.Thread(target=ask)
    asking.start()
    children = Path(f"/proc/{parent}/task/{parent}/children")
    child = int(wait_until(children.read_text, "the child", HUNG))
    # It has asked to end with its parent before it reads anything.
    wait_until(lambda: cpu_time(child) > 0.05, "the child to compute", HUNG)
    os.kill(child, signal.SIGSTOP)
    os.kill(parent, signal.SIGKILL)
    asking.join()
    client.close()
    try:
        wait_until(lambda: not _runs(child), "the child to end", HUNG)
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.kill(child, signal.SIGKILL)


def stat(pid):
    """Fields of a process's status from its state on."""
    return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()


def cpu_time(pid):
    return sum(map(int, stat(pid)[11:13])) / os.sysconf("SC_CLK_TCK")


def _runs(pid):
    try:
        return stat(pid)[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


def test_a_default_timeout_of_sockets_is_no_matter():
    before = socket.getdefaulttimeout()
    socket.setdefaulttimeout(0.05)
    try:
        client = RehearsalClient(shipped_config())
        try:
            assert client.scene("floor", []).scene.name == "floor"
            time.sleep(0.3)
            # It waits for the next request.
            assert client._process.poll() is None
        finally:
            client.close()
    finally:
        socket.setdefaulttimeout(before)


def test_a_mesh_that_is_no_file_is_refused(rehearsal, tmp_path):
    os.mkfifo(tmp_path / "pipe.stl")
    with pytest.raises(ConfigError, match="pipe.stl: it is no file"):
        rehearsal.robot(box_robot(f'<mesh filename="file://{tmp_path}/pipe.stl"/>'), Start())


class Unreadable:
    what = "the object"

    def answer(self, stage):
        raise PermissionError(13, "Permission denied", "/secret.obj")


class Killed:
    what = "the object"

    def answer(self, stage):
        os.kill(os.getpid(), signal.SIGKILL)


class Asleep:
    what = "the object"

    def answer(self, stage):
        time.sleep(60.0)


class Little:
    """Computes now and then, as on a busy machine."""

    what = "the object"

    def __init__(self, seconds):
        self.seconds = seconds

    def answer(self, stage):
        end = time.monotonic() + self.seconds
        while time.monotonic() < end:
            time.sleep(0.01)
        yield "an answer"


def perform(request):
    """What it answers, and how the process ended that was to give it."""
    memory, status = _perform(request, _Stage(shipped_config()))
    with open(memory, "rb") as answer:
        answer.seek(0)
        return list(read_values(answer.read)) if status == 0 else [], status


def why_ended(request):
    return str(_why_ended(request, perform(request)[1], 1024**3))


def test_who_is_killed_from_outside_has_not_taken_too_long():
    assert "killed from outside" in why_ended(Killed())


def test_who_waits_is_ended_and_who_computes_little_only_much_later(monkeypatch):
    monkeypatch.setattr(rehearsal_process, "_LOOK", 0.1)
    monkeypatch.setattr(rehearsal_process, "MOST_WAITING", 2.0)
    assert "it waited for more than 2 s;" in why_ended(Asleep())
    assert perform(Little(3.0)) == (["an answer"], 0)
    monkeypatch.setattr(rehearsal_process, "MOST_TIME", 1.0)
    assert "it took more than 1 s;" in why_ended(Little(60.0))


def test_who_ends_while_it_is_given_up_has_not_taken_too_long(monkeypatch):
    def late(pid, lives):
        os.waitid(os.P_PID, pid, os.WEXITED | os.WNOWAIT)
        return rehearsal_process._TOO_LATE

    monkeypatch.setattr(rehearsal_process, "_wait_for_end", late)
    assert perform(Little(0.0)) == (["an answer"], 0)


def test_what_cannot_be_read_is_told_as_it_is():
    (error,), status = perform(Unreadable())
    assert status == 0
    assert isinstance(error, ConfigError)
    assert "the object: [Errno 13] Permission denied: '/secret.obj'" in str(error)


def test_it_steps_back_before_it_imports_what_takes_long():
    code = "import sys, telex_sim.rehearsal.start; sys.exit('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
