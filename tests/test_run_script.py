"""run.sh as a person uses it: start, read what it prints, Ctrl-C."""

from __future__ import annotations

import contextlib
import importlib.util
import json
import math
import os
import pty
import re
import select
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
import urllib.error
import urllib.request
from io import StringIO
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import pytest
import rosgraph
from waiting import wait_until

from telex_experiments.rigs.private_master import free_port

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[1]
OPENS_ROS = ("ROS_IP", "ROS_HOSTNAME")
FOREVER = 300.0
"""Longer than any program takes that these tests wait for (s)."""
ENDING = 10.0
"""It asks for 3 s of its own clock, then kills (s); the rest is a busy machine's."""
LOOPBACK = "0100007F"
"""127.0.0.1 as /proc/net/tcp has it."""


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
    inherited = {key: text for key, text in os.environ.items() if key not in OPENS_ROS}
    return marker, {**inherited, "ROS_MASTER_URI": marker, "ROS_LOG_DIR": str(tmp_path)}


def run(*arguments, environment=None):
    """Start run.sh where it will not get far, and wait for its end."""
    return subprocess.run(
        ["./launch_scripts/run.sh", *arguments],
        cwd=ROOT,
        env=environment,
        capture_output=True,
        text=True,
        timeout=FOREVER,
        check=False,
    )


def listening(session_marker):
    """Addresses that those processes listen on by TCP, each with the process's command line."""
    sockets = {}
    for table in ("tcp", "tcp6"):
        for line in Path("/proc/net", table).read_text().splitlines()[1:]:
            _, local, _, state, *_, inode = line.split()[:10]
            if state == "0A":
                sockets[f"socket:[{inode}]"] = local.partition(":")[0]
    found = []
    for entry in Path("/proc").iterdir():
        try:
            if not entry.name.isdigit() or session_marker not in (entry / "environ").read_bytes():
                continue
            command = (entry / "cmdline").read_bytes().replace(b"\0", b" ").decode()
            for file in (entry / "fd").iterdir():
                address = sockets.get(os.readlink(file))
                if address is not None:
                    found.append((address, command))
        except OSError:
            continue
    return found


def fetch(url):
    try:
        with urllib.request.urlopen(url, timeout=20.0) as answer:
            return answer.status, answer.read()
    except urllib.error.HTTPError as answer:
        return answer.code, answer.read()


@pytest.fixture
def wait_ready():
    """The module of the script that run.sh waits with."""
    path = ROOT / "launch_scripts" / "wait_ready.py"
    spec = importlib.util.spec_from_file_location("wait_ready", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_a_token_file_that_is_gone_does_not_fail_the_start(wait_ready, monkeypatch, tmp_path):
    gone = str(tmp_path / "token")
    monkeypatch.setattr(wait_ready.rospy, "get_param", lambda *_: gone)
    monkeypatch.setattr(wait_ready.sys, "stdout", StringIO())
    wait_ready.sys.stdout.isatty = lambda: True
    said = wait_ready.pages("/telex", "http://h:1", False).splitlines()
    assert [line.split()[1] for line in said] == [
        "http://h:1/?token=…",
        "http://h:1/instructor?token=…",
    ]
    assert all(line.endswith(f"with the token in {gone}") for line in said)


def test_it_asks_this_machine_past_a_proxy(wait_ready, monkeypatch):
    monkeypatch.setenv("http_proxy", "http://127.0.0.1:9")
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve():
            for _ in range(2):
                client, _ = server.accept()
                head = client.recv(4096).startswith(b"HEAD")
                status = "405 no" if head else "200 OK"
                client.sendall(f"HTTP/1.0 {status}\r\n\r\n<!DOCTYPE html>".encode())
                client.close()

        threading.Thread(target=serve, daemon=True).start()
        host, port = server.getsockname()
        urls = {"video_server": f"http://{host}:{port}", "rosbridge": f"ws://{host}:{port}"}
        monkeypatch.setattr(
            wait_ready.rospy, "get_param", lambda name, _: urls[name.split("/")[-2]]
        )
        assert wait_ready.console("/telex") == urls["video_server"]
        assert wait_ready.bridge_answers("/telex") == urls["rosbridge"]


class TestWaiter:
    @pytest.fixture
    def running(self, wait_ready, monkeypatch):
        """Names of nodes that answer; time goes on while one waits."""
        running, now = set(), [0.0]
        clock = SimpleNamespace(
            monotonic=lambda: now[0],
            sleep=lambda duration: now.__setitem__(0, now[0] + duration),
        )
        monkeypatch.setattr(wait_ready, "time", clock)
        monkeypatch.setattr(wait_ready, "node_answers", running.__contains__)
        return running

    def test_a_node_that_is_needed_late_has_its_time_from_then(self, wait_ready, running):
        waiter = wait_ready.Waiter(0, 120.0)
        wait_ready.time.sleep(60.0)
        waiter.need(["/telex/rosbridge"])
        looks = iter([False, False, True])
        assert waiter.wait("bridge", lambda: next(looks))
        with pytest.raises(SystemExit, match="the node /telex/rosbridge has ended"):
            waiter.wait("bridge", lambda: False)

    def test_one_of_several_that_refuses_to_start_ends_the_wait(self, wait_ready, running):
        waiter = wait_ready.Waiter(0, 120.0)
        waiter.need(["/telex/arm_teleop", "/telex/track_teleop"], within=math.inf)
        looks = []

        def look():
            looks.append(None)
            running.clear()
            running.add("/telex/arm_teleop")
            if len(looks) == 300:
                running.add("/telex/track_teleop")

        with pytest.raises(SystemExit, match="/telex/track_teleop has ended: its last message"):
            waiter.wait("teleoperation", look)
        assert len(looks) == 301


@pytest.mark.parametrize(
    ("master", "says"),
    [
        ("http://localhost:11311", "source env.sh"),
        ("http://localhost:9", "export ROS_MASTER_URI=http://localhost:9 && source env.sh"),
    ],
)
def test_the_commands_that_are_shown_are_for_this_master(wait_ready, monkeypatch, master, says):
    monkeypatch.setenv("ROS_MASTER_URI", master)
    assert wait_ready.shell() == says


def test_the_first_picture_may_be_of_any_camera(wait_ready, monkeypatch):
    now, asked = [0.0], []
    names = ("overview", "rear", "front")
    config = {
        "cameras": [{"name": name, "topic": f"/c/{name}"} for name in names],
        "main_camera": "front",
        "hidden_cameras": ["overview"],
    }
    monkeypatch.setattr(wait_ready, "fetch", lambda *_: ("http://h:1", json.dumps(config)))
    monkeypatch.setattr(wait_ready, "time", SimpleNamespace(monotonic=lambda: now[0]))
    published = [["/c/front/compressed", ""], ["/c/rear", ""], ["/c/overview/compressed", ""]]
    monkeypatch.setattr(wait_ready.rospy, "get_published_topics", lambda: published)
    monkeypatch.setattr(wait_ready.rospy, "Subscriber", lambda topic, *_, **__: asked.append(topic))
    first = wait_ready.FirstPicture("/c")
    for _ in range(2):
        assert not first.came()
        assert asked == ["/c/front/compressed"]
    now[0] = 6.0
    assert not first.came()
    assert asked == ["/c/front/compressed", "/c/rear", "/c/overview/compressed"]
    first._note(None)
    assert first.came()


@pytest.mark.ros
@pytest.mark.waiting
def test_run_starts_everything_and_ctrl_c_leaves_nothing(private):
    marker, environment = private
    terminal = Terminal(
        ["./launch_scripts/run.sh", "video_port:=0", "bridge_port:=0", "pose:=drive"], environment
    )
    try:
        assert terminal.read_until(r"Stop +Ctrl-C", FOREVER), terminal.text[-3000:]
        url = re.search(r"Console +(http://127\.0\.0\.1:\d+)", terminal.text).group(1)
        with urllib.request.urlopen(url, timeout=10.0) as answer:
            assert b"<html" in answer.read()
        assert re.search(r"robot controllable: ", terminal.text)
        assert re.search(r"teleoperation: ", terminal.text)
        assert re.search(r"first camera picture: ", terminal.text)
        names = " ".join(processes_of(marker.encode()))
        for node in ("simulator", "cameras", "arm_teleop", "video_server", "rosmaster"):
            assert node in names
        # roscpp has no setting for its XML-RPC servers; docs/engineer/network.md says what these
        # let do.
        sockets = listening(marker.encode())
        open_ones = [command for address, command in sockets if address != LOOPBACK]
        assert len(sockets) > 15
        assert len(open_ones) == 2
        for command in open_ones:
            assert "/rosout/rosout" in command or "/robot_state_publisher " in command
        assert "ROS is open" not in terminal.text
        ports = ("video_port:=0", "bridge_port:=0")
        second = run(*ports, environment=environment)
        assert second.returncode == 2
        assert f"/telex/simulator runs already on the ROS master {marker}" in second.stderr
        assert processes_of(marker.encode()) != []
        with urllib.request.urlopen(url, timeout=10.0) as answer:
            assert b"<html" in answer.read()
    finally:
        os.write(terminal.fd, b"\x03")
        stopped_at = time.monotonic()
    assert not terminal.read_until(None, FOREVER)
    took = time.monotonic() - stopped_at
    _, status = os.waitpid(terminal.pid, 0)
    assert took < ENDING
    assert os.WEXITSTATUS(status) == 130
    assert processes_of(marker.encode()) == []


@pytest.mark.ros
@pytest.mark.waiting
def test_it_starts_on_an_address_that_needs_tokens_without_a_front_camera(private, tmp_path):
    marker, environment = private
    (tmp_path / "mine").write_text("sesame")
    (tmp_path / "mine").chmod(0o600)
    terminal = Terminal(
        [
            "./launch_scripts/run.sh",
            *("address:=0.0.0.0", "video_port:=0", "bridge_port:=0", "world:=floor"),
            *("options:=cameras=rear", f"token_file:={tmp_path}/mine"),
            f"instructor_token_file:={tmp_path}/made",
        ],
        environment,
    )
    try:
        assert terminal.read_until(r"Stop +Ctrl-C", FOREVER), terminal.text[-3000:]
        url, token = re.search(r"Console +(http:\S+/)\?token=(\S+)", terminal.text).groups()
        page, teacher = re.search(r"Instructor +(\S+)\?token=(\S+)", terminal.text).groups()
        assert page == f"{url}instructor"
        assert token == "sesame"
        assert (tmp_path / "made").exists()
        assert fetch(f"{url}?token={token}")[0] == 200
        picture = f"{url}snapshot?topic=/telex/cameras/rear/image_raw"
        assert fetch(picture)[0] == 401
        for each in (token, teacher):
            assert fetch(f"{picture}&token={each}")[1].startswith(b"\xff\xd8")
        parameters = str(rosgraph.Master("/test", master_uri=marker).getParam("/"))
        logs = "".join(path.read_text(errors="replace") for path in tmp_path.rglob("*.log*"))
        for secret in (token, teacher):
            assert secret not in " ".join(processes_of(marker.encode()))
            assert secret not in parameters
            assert secret not in logs
    finally:
        os.write(terminal.fd, b"\x03")
    assert not terminal.read_until(None, FOREVER)
    os.waitpid(terminal.pid, 0)
    assert processes_of(marker.encode()) == []


@pytest.mark.ros
@pytest.mark.waiting
@pytest.mark.parametrize("delay", [1.0, 3.0])
def test_ctrl_c_while_it_starts_leaves_nothing_either(private, delay):
    marker, environment = private
    terminal = Terminal(["./launch_scripts/run.sh", "video_port:=0", "bridge_port:=0"], environment)
    assert terminal.read_until("Starting the simulator", FOREVER), terminal.text[-3000:]
    time.sleep(delay)
    os.write(terminal.fd, b"\x03")
    stopped_at = time.monotonic()
    assert not terminal.read_until(None, FOREVER)
    took = time.monotonic() - stopped_at
    _, status = os.waitpid(terminal.pid, 0)
    assert processes_of(marker.encode()) == []
    assert took < ENDING
    assert os.WEXITSTATUS(status) == 130


@pytest.mark.parametrize("said", [b"", b"nonsense", b"HTTP/1.0 200 OK\r\n\r\n<html>"])
def test_what_is_no_master_runs_no_simulator(said):
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve():
            with contextlib.suppress(OSError):  # the server is closed at the end
                while True:
                    client, _ = server.accept()
                    client.recv(4096)
                    client.sendall(said)
                    client.close()

        threading.Thread(target=serve, daemon=True).start()
        address = "http://{}:{}".format(*server.getsockname())
        done = subprocess.run(
            [sys.executable, "launch_scripts/running.py", "telex"],
            cwd=ROOT,
            env={**os.environ, "ROS_MASTER_URI": address},
            capture_output=True,
            text=True,
            timeout=FOREVER,
            check=False,
        )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


@pytest.mark.ros
@pytest.mark.waiting
def test_a_port_in_use_is_said_and_ends_the_start(private):
    marker, environment = private
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        arguments = ["video_port:=0", f"bridge_port:={port}", "cameras:=false", "world:=floor"]
        terminal = Terminal(["./launch_scripts/run.sh", *arguments], environment)
        assert not terminal.read_until(None, FOREVER)
    _, status = os.waitpid(terminal.pid, 0)
    assert os.WEXITSTATUS(status) == 1
    assert "try bridge_port:=9091" in terminal.text
    assert "Console " not in terminal.text
    assert str(port) in terminal.text
    assert processes_of(marker.encode()) == []


@pytest.mark.ros
@pytest.mark.waiting
def test_a_start_that_fails_says_why_and_leaves_nothing(private):
    marker, environment = private
    terminal = Terminal(
        [
            *("./launch_scripts/run.sh", "video_port:=0", "bridge_port:=0", "cameras:=false"),
            *("world:=floor", "pose:=handstand"),
        ],
        environment,
    )
    assert not terminal.read_until(None, FOREVER)
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
    done = run(*arguments)
    assert done.returncode == 2
    assert f"unknown argument '{arguments[-1]}'; there are: ns:= gui:= " in done.stderr
    assert " world:= " in done.stderr
    assert " options:= " in done.stderr
    assert done.stdout == ""


@pytest.mark.parametrize("name", ["token", "instructor_token"])
def test_a_token_on_the_command_line_is_refused_and_not_shown(name):
    done = run(f"{name}:=sesame")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"run.sh: {name}:= is gone")
    assert f"give {name}_file:=FILE" in done.stderr
    assert "sesame" not in done.stderr


@pytest.mark.parametrize("launch_file", ["bringup.launch", "console.launch"])
@pytest.mark.parametrize("name", ["token", "instructor_token"])
def test_roslaunch_refuses_it_too(launch_file, name):
    done = subprocess.run(
        ["roslaunch", "--dump-params", "telex_teleop", launch_file, f"{name}:=sesame"],
        capture_output=True,
        text=True,
        timeout=FOREVER,
        check=False,
    )
    assert done.stdout == ""  # there is nothing to be started
    assert f"give {name}_file:=FILE" in done.stderr
    assert "sesame" not in done.stderr


@pytest.mark.parametrize("address", ["0.0.0.0", "192.0.2.77", "no.such.host.invalid"])
def test_ros_is_not_opened_at_what_is_no_address_of_this_machine(private, address):
    _, environment = private
    done = run(f"ros_address:={address}", environment=environment)
    assert done.returncode == 2
    assert f"ros_address:={address} is no name or address of this machine" in done.stderr


@pytest.mark.parametrize(
    ("given", "ros_ip", "master"),
    [
        ({}, "127.0.0.1", "http://localhost:11311"),
        ({"ROS_MASTER_URI": "http://127.0.0.1:11399"}, "127.0.0.1", "http://127.0.0.1:11399"),
        # Nodes that are for this machine alone need a master that is found there.
        ({"ROS_MASTER_URI": "http://127.0.0.9:2/"}, "127.0.0.1", "http://127.0.0.1:2"),
        ({"ROS_MASTER_URI": "http://[::1]:2/"}, "127.0.0.1", "http://127.0.0.1:2"),
        ({"ROS_MASTER_URI": "http://192.0.2.77:11311"}, "", "http://192.0.2.77:11311"),
        ({"ROS_MASTER_URI": "http://[2001:db8::7]:2"}, "", "http://[2001:db8::7]:2"),
        ({"ROS_IP": "192.0.2.77"}, "192.0.2.77", "http://localhost:11311"),
        ({"ROS_HOSTNAME": "robot"}, "", "http://localhost:11311"),
        ({"ROS_IP": "", "ROS_HOSTNAME": ""}, "127.0.0.1", "http://localhost:11311"),
    ],
)
def test_ros_is_for_this_machine_unless_told_otherwise(given, ros_ip, master):
    bare = {key: text for key, text in os.environ.items() if not key.startswith("ROS_")}
    done = subprocess.run(
        ["bash", "-uc", '. ./env.sh && echo "${ROS_IP-}" "$ROS_MASTER_URI"; which rosmaster'],
        cwd=ROOT,
        env={**bare, **given},
        capture_output=True,
        text=True,
        timeout=FOREVER,
        check=True,
    )
    own = ROOT / "src" / "telex_control" / "bin" / "rosmaster"
    assert done.stdout == f"{ros_ip} {master}\n{own}\n"


def test_every_argument_of_the_launch_file_is_known(tmp_path):
    """With a set-up that fails, run.sh ends right after it has looked at its arguments."""
    launch = ROOT / "src" / "telex_training" / "launch" / "station.launch"
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
            *(f"{name}:=x" for name in names),
        ],
        capture_output=True,
        text=True,
        timeout=FOREVER,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (1, "begins\n", "")
    assert len(names) > 20


@pytest.mark.parametrize(
    "given", [["-p", "11399"], ["--screen", "--port", "11399"], ["-p11399"], ["--port=11399"]]
)
def test_the_masters_port_holds_for_all_that_is_started(tmp_path, given):
    done = run_alone(tmp_path, *given, environment='echo "$ROS_MASTER_URI"; exit 0')
    assert (done.returncode, done.stdout) == (0, "http://localhost:11399\n")


@pytest.mark.parametrize("port", ["0", "65536", "eleven", "-1"])
def test_a_port_that_no_master_can_have_is_refused(tmp_path, port):
    done = run_alone(tmp_path, "-p", port)
    assert done.returncode == 2
    assert f"port is '{port}'; 1 to 65535" in done.stderr


def alone(tmp_path, environment):
    """run.sh with a set-up that does nothing, and a server of a class that tells its arguments."""
    script = tmp_path / "launch_scripts" / "run.sh"
    script.parent.mkdir(parents=True)
    script.write_bytes((ROOT / "launch_scripts" / "run.sh").read_bytes())
    server = tmp_path / "src" / "telex_training" / "nodes" / "class"
    server.parent.mkdir(parents=True)
    (tmp_path / "env.sh").write_text(environment)
    for name in ("telex_training/launch/station.launch", "telex_teleop/launch/own_robot.launch"):
        copy = tmp_path / "src" / name
        copy.parent.mkdir(parents=True)
        copy.write_bytes((ROOT / "src" / name).read_bytes())
    for path, text in (
        (script.with_name("setup.sh"), "exit 0"),
        (server, "printf '%s\\n' \"$@\""),
    ):
        path.write_text(f"#!/bin/sh\n{text}\n")
        path.chmod(0o755)
    return script


def run_alone(tmp_path, *arguments, environment=""):
    return subprocess.run(
        ["bash", str(alone(tmp_path, environment)), *arguments],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=FOREVER,
        check=False,
    )


def test_it_ends_what_it_started_when_nobody_reads_its_output_any_more(tmp_path):
    """As by Ctrl-C on "run.sh | tee log", which ends tee as well."""
    python = tmp_path / "bin" / "python"
    python.parent.mkdir()
    python.write_text("#!/bin/sh\ncase $1 in -c | */wait_ready.py) exec sleep 60;; esac\n")
    python.chmod(0o755)
    # It looks for what is left of it by grep, which takes its time on a busy machine.
    looks, grep = tmp_path / "looks", python.with_name("grep")
    grep.write_text(f"#!/bin/sh\necho >>'{looks}'\nsleep 0.3\nexec {shutil.which('grep')} \"$@\"\n")
    grep.chmod(0o755)
    script = alone(tmp_path, f'PATH="{python.parent}:$PATH"')
    running = subprocess.Popen(
        ["bash", str(script)], cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    assert b"Starting" in running.stdout.readline()
    mark = f"TELEX_RUN={running.pid}-".encode()
    wait_until(lambda: len(processes_of(mark)) >= 2, "both programs to run", FOREVER, 0.05)
    running.stdout.close()
    running.terminate()
    assert running.wait(FOREVER) == 143
    assert processes_of(mark) == []
    assert len(looks.read_text()) < 20


def test_ctrl_c_while_it_is_set_up_ends_it_as_later(tmp_path):
    script = alone(tmp_path, "")
    script.with_name("setup.sh").write_text("#!/bin/sh\necho begins\nexec sleep 600\n")
    terminal = Terminal(["bash", str(script)], os.environ)
    assert terminal.read_until("begins", FOREVER), terminal.text
    os.write(terminal.fd, b"\x03")
    assert not terminal.read_until(None, FOREVER)
    _, status = os.waitpid(terminal.pid, 0)
    assert os.WIFEXITED(status)
    assert os.WEXITSTATUS(status) == 130
    assert "Starting" not in terminal.text


def test_the_robots_namespace_is_not_put_below_another(tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_NAMESPACE", "/telex")
    done = run_alone(tmp_path, environment='echo "<${ROS_NAMESPACE-}>"; exit 0')
    assert done.stdout == "<>\n"


def test_the_checkout_is_the_same_by_whatever_name_it_is_started(tmp_path):
    """Set-up takes one that is elsewhere for one that was moved, and makes all anew."""
    script = alone(tmp_path / "checkout", 'echo "$root"; exit 0')
    (tmp_path / "link").symlink_to("checkout")
    for name in ("checkout", "link"):
        started = tmp_path / name / "launch_scripts" / script.name
        done = subprocess.run(["bash", str(started)], capture_output=True, text=True, check=True)
        assert done.stdout == f"{tmp_path.resolve() / 'checkout'}\n"


def test_an_argument_without_a_value_is_refused_where_roslaunch_would_take_another(tmp_path):
    """It passes over arguments that are empty, and says nothing."""
    done = run_alone(tmp_path, "speed:=", environment="exit 0")
    assert done.returncode == 2
    assert done.stderr == "run.sh: speed:= has no value; leave it out, or give one\n"
    shutil.rmtree(tmp_path)
    tmp_path.mkdir()
    assert run_alone(tmp_path, "joy_dev:=", environment="exit 0").returncode == 0


def test_a_class_is_shown_without_ros(tmp_path):
    given = ["class:=my stations.yaml", "class_port:=8071", "address:=0.0.0.0", "token_file:=t"]
    done = run_alone(tmp_path, *given)
    wanted = ["--port", "8071", "--address", "0.0.0.0", "--token-file", "t", "--"]
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines() == [*wanted, "my stations.yaml"]


def test_a_class_refuses_what_a_station_takes(tmp_path):
    done = run_alone(tmp_path, "class:=stations.yaml", "world:=stairs")
    assert done.returncode == 2
    known = "class:= class_port:= address:= token_file:="
    assert f"unknown argument 'world:=stairs'; there are: {known}" in done.stderr


TELLS = """
python() { /usr/bin/printf '%s\\n' "$@"; }
env() { shift; "$@"; }
setsid() { "$@"; }
"""
"""Programs that tell what they were to do, each in one piece: two run at once."""


def test_a_robot_of_ones_own_is_started_from_the_callers_folder(tmp_path):
    files = ["rover.urdf", "controllers.yaml", "base.yaml", "cameras.yaml"]
    for name in files:
        (tmp_path / name).touch()
    given = [f"{key}:={name}" for key, name in zip(("model", "controllers", "base"), files)]
    done = run_alone(tmp_path, *given, "world:=floor", environment=TELLS)
    told = done.stdout.splitlines()
    at = told.index("own_robot.launch")
    assert told[at - 1] == "telex_teleop"
    wanted = [f"{key}:={tmp_path / name}" for key, name in zip(("model", "controllers"), files)]
    assert told[at + 1 : at + 5] == [*wanted, f"base:={tmp_path / 'base.yaml'}", "world:=floor"]
    at = told.index("--namespace")
    waits = ["--namespace", "robot", "--own-robot", "track_teleop", "--no-picture"]
    assert told[at : at + 5] == waits


def test_a_stations_own_keys_and_pad_are_of_the_callers_folder(tmp_path):
    (tmp_path / "keys.yaml").touch()
    (tmp_path / "pad.yaml").touch()
    done = run_alone(tmp_path, "actions:=keys.yaml", "joy_map:=pad.yaml", environment=TELLS)
    told = done.stdout.splitlines()
    assert f"actions:={tmp_path / 'keys.yaml'}" in told
    assert f"joy_map:={tmp_path / 'pad.yaml'}" in told


def test_a_station_is_refused_keys_that_are_not_there(tmp_path):
    done = run_alone(tmp_path, "actions:=~/no/keys.yaml", environment=TELLS)
    assert done.returncode == 2
    assert "run.sh: actions:=~/no/keys.yaml: there is no file /" in done.stderr


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("base:=wheels.yaml", "run.sh: base:=wheels.yaml: there is no file "),
        ("robots:=2", "unknown argument 'robots:=2'; there are: model:= options:= controllers:= "),
    ],
)
def test_a_robot_of_ones_own_is_refused_what_it_cannot_have(tmp_path, given, said):
    (tmp_path / "rover.urdf").touch()
    done = run_alone(tmp_path, "model:=rover.urdf", given, environment=TELLS)
    assert done.returncode == 2
    assert said in done.stderr
