"""run.sh as a person uses it: start, read what it prints, Ctrl-C."""

from __future__ import annotations

import os
import pty
import re
import select
import signal
import socket
import subprocess
import time
import urllib.request
from pathlib import Path
from xml.etree import ElementTree

import pytest

from telex_control.private_master import free_port

ROOT = Path(__file__).resolve().parents[1]


class Terminal:
    """A program on a pseudo terminal."""

    def __init__(self, command, environment):
        self.text = ""
        self.pid, self.fd = pty.fork()
        if self.pid == 0:
            # Whoever started the tests may ignore it (a shell's background job does), and a shell
            # cannot trap what was ignored when it began.
            signal.signal(signal.SIGINT, signal.SIG_DFL)
            os.chdir(ROOT)
            os.execvpe(command[0], command, environment)

    def read_until(self, pattern, timeout):
        """Read until the output matches; returns whether it did before the end."""
        end = time.monotonic() + timeout
        while time.monotonic() < end:
            if pattern is not None and re.search(pattern, self.text):
                return True
            ready, _, _ = select.select([self.fd], [], [], 0.1)
            if not ready:
                continue
            try:
                data = os.read(self.fd, 65536)
            except OSError:
                return False
            if not data:
                return False
            self.text += data.decode(errors="replace")
        raise AssertionError(f"no {pattern!r} within {timeout} s:\n{self.text[-3000:]}")


def processes_of(session_marker):
    """Command lines of all processes whose environment holds the marker."""
    found = []
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            if session_marker in (entry / "environ").read_bytes():
                found.append((entry / "cmdline").read_bytes().replace(b"\0", b" ").decode())
        except OSError:
            continue
    return found


@pytest.fixture
def private(tmp_path):
    """A master address of one's own, which marks all processes, and the environment with it."""
    marker = f"http://127.0.0.1:{free_port()}"
    return marker, {
        **os.environ,
        "ROS_MASTER_URI": marker,
        "ROS_IP": "127.0.0.1",
        "ROS_LOG_DIR": str(tmp_path),
    }


@pytest.mark.ros
def test_run_starts_everything_and_ctrl_c_leaves_nothing(private):
    marker, environment = private
    terminal = Terminal(
        ["./launch_scripts/run.sh", "video_port:=0", "bridge_port:=0", "pose:=drive"], environment
    )
    try:
        assert terminal.read_until(r"Stop +Ctrl-C", 120.0), terminal.text[-3000:]
        url = re.search(r"Console +(http://127\.0\.0\.1:\d+)", terminal.text).group(1)
        with urllib.request.urlopen(url, timeout=10.0) as answer:
            assert b"<html" in answer.read()
        assert re.search(r"robot controllable: ", terminal.text)
        assert re.search(r"first camera picture: ", terminal.text)
        names = " ".join(processes_of(marker.encode()))
        for node in ("simulator", "cameras", "arm_teleop", "video_server", "rosmaster"):
            assert node in names
    finally:
        os.write(terminal.fd, b"\x03")
        stopped_at = time.monotonic()
    assert not terminal.read_until(None, 30.0)
    took = time.monotonic() - stopped_at
    _, status = os.waitpid(terminal.pid, 0)
    assert took < 5.0
    assert os.WEXITSTATUS(status) == 130
    assert processes_of(marker.encode()) == []


@pytest.mark.ros
@pytest.mark.parametrize("delay", [1.0, 2.0, 3.5])
def test_ctrl_c_while_it_starts_leaves_nothing_either(private, delay):
    marker, environment = private
    terminal = Terminal(["./launch_scripts/run.sh", "video_port:=0", "bridge_port:=0"], environment)
    time.sleep(delay)
    os.write(terminal.fd, b"\x03")
    stopped_at = time.monotonic()
    assert not terminal.read_until(None, 30.0)
    took = time.monotonic() - stopped_at
    _, status = os.waitpid(terminal.pid, 0)
    assert processes_of(marker.encode()) == []
    assert took < 5.0
    assert os.WEXITSTATUS(status) == 130


@pytest.mark.ros
@pytest.mark.parametrize(
    ("taken_by", "advice"),
    [("video_port", "try video_port:=8081"), ("bridge_port", "try bridge_port:=9091")],
)
def test_a_port_in_use_is_said_and_ends_the_start(private, taken_by, advice):
    marker, environment = private
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        ports = {"video_port": 0, "bridge_port": 0, taken_by: port}
        arguments = [f"{name}:={value}" for name, value in ports.items()]
        terminal = Terminal(["./launch_scripts/run.sh", *arguments], environment)
        assert not terminal.read_until(None, 60.0)
    _, status = os.waitpid(terminal.pid, 0)
    assert os.WEXITSTATUS(status) == 1
    assert advice in terminal.text
    assert "Console " not in terminal.text
    assert str(port) in terminal.text
    assert processes_of(marker.encode()) == []


@pytest.mark.ros
def test_a_start_that_fails_says_why_and_leaves_nothing(private):
    marker, environment = private
    terminal = Terminal(
        ["./launch_scripts/run.sh", "video_port:=0", "bridge_port:=0", "pose:=handstand"],
        environment,
    )
    assert not terminal.read_until(None, 60.0)
    _, status = os.waitpid(terminal.pid, 0)
    assert os.WEXITSTATUS(status) == 1
    assert "pose is 'handstand'; there are: drive" in terminal.text
    assert processes_of(marker.encode()) == []


@pytest.mark.parametrize(
    "arguments",
    [
        ["wrold:=stairs"],
        ["world:=stairs", "stairs"],
        ["--screen", "--port", "11399", "gui"],
        ["worl[d]:=stairs"],
        [":=stairs"],
        ["restarter:=none"],
        [""],
    ],
)
def test_an_argument_that_nobody_asks_for_is_refused_at_once(arguments):
    done = subprocess.run(
        ["./launch_scripts/run.sh", *arguments],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=30.0,
        check=False,
    )
    assert done.returncode == 2
    assert f"unknown argument '{arguments[-1]}'; there are: ns:= gui:= " in done.stderr
    assert " world:= " in done.stderr
    assert " options:= " in done.stderr
    assert done.stdout == ""


def test_every_argument_of_the_launch_file_is_known(tmp_path):
    """With a set-up that fails, run.sh ends right after it has looked at its arguments."""
    launch = ROOT / "src" / "telex_teleop" / "launch" / "bringup.launch"
    for path in (launch, ROOT / "launch_scripts" / "run.sh"):
        copy = tmp_path / path.relative_to(ROOT)
        copy.parent.mkdir(parents=True)
        copy.write_bytes(path.read_bytes())
    set_up = tmp_path / "launch_scripts" / "setup.sh"
    set_up.write_text("#!/bin/sh\necho begins\nexit 1\n")
    set_up.chmod(0o755)
    names = [each.get("name") for each in ElementTree.parse(launch).getroot().findall("arg")]
    done = subprocess.run(
        [
            *("bash", str(tmp_path / "launch_scripts" / "run.sh"), "--screen", "-p", "11399"),
            *(f"{name}:=" for name in names),
        ],
        capture_output=True,
        text=True,
        timeout=30.0,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (1, "begins\n", "")
    assert len(names) > 20
