"""The ROS master that tests and benchmarks have for themselves."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from xmlrpc.server import SimpleXMLRPCServer

import pytest
import rosgraph
from waiting import wait_until

from telex_experiments.rigs import private_master
from telex_experiments.rigs.private_master import (
    PrivateMaster,
    PrivateMasterError,
    descendants,
    end_tree,
    free_port,
)

pytestmark = pytest.mark.waiting

# Starts a child in a session of its own, as roslaunch does, says its id, and waits.
PARENT = """
import signal, subprocess, sys, time
polite = sys.argv[1] == "polite"
signal.signal(signal.SIGINT, signal.SIG_DFL if polite else signal.SIG_IGN)
child = subprocess.Popen(["sleep", "60"], start_new_session=True)
print(child.pid, flush=True)
time.sleep(60)
"""


def is_running(pid):
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


@pytest.mark.parametrize(
    ("manner", "end"), [("polite", signal.SIGINT), ("stubborn", signal.SIGKILL)]
)
def test_no_descendant_remains(manner, end):
    process = subprocess.Popen(
        [sys.executable, "-c", PARENT, manner], stdout=subprocess.PIPE, start_new_session=True
    )
    with process.stdout:
        child = int(process.stdout.readline())
        assert child in descendants(process.pid)
        end_tree(process, timeout=5.0 if end == signal.SIGINT else 0.5)
    wait_until(lambda: not is_running(child), "the child to end", 5.0)
    assert process.returncode == -end


def test_a_thread_that_ends_meanwhile_hides_no_descendant(monkeypatch):
    listed = os.listdir
    # Two that have ended by the time they are looked at.
    monkeypatch.setattr(os, "listdir", lambda path: ["0", *listed(path), "0"])
    with subprocess.Popen(["sleep", "60"]) as child:
        try:
            assert child.pid in descendants(os.getpid())
        finally:
            child.kill()


@pytest.mark.ros
def test_master_is_there_and_gone(monkeypatch):
    monkeypatch.setenv("ROS_NAMESPACE", "/elsewhere")
    # Other tests of this process may have a master of their own.
    others = set(descendants(os.getpid()))
    with PrivateMaster() as master:
        environment = master.environment(PLACE="here")
        assert rosgraph.is_master_online(master.uri)
        assert environment["ROS_MASTER_URI"] == master.uri
        assert environment["PLACE"] == "here"
        assert "ROS_NAMESPACE" not in environment
        tree = set(descendants(os.getpid())) - others
        assert tree
        assert os.path.isdir(environment["ROS_LOG_DIR"])
    wait_until(lambda: not any(map(is_running, tree)), "the master to end", 15.0)
    assert not rosgraph.is_master_online(master.uri)
    assert not os.path.exists(environment["ROS_HOME"])


def test_master_that_does_not_come_up_says_why(monkeypatch, tmp_path):
    program = tmp_path / "roscore"
    program.write_text("#!/bin/sh\necho no such thing\nexit 3\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    monkeypatch.setattr(private_master, "START_TIMEOUT", 5.0)
    with pytest.raises(PrivateMasterError, match="no such thing"), PrivateMaster():
        pass


def test_another_server_is_not_taken_for_the_master(monkeypatch, tmp_path):
    program = tmp_path / "roscore"
    program.write_text("#!/bin/sh\nexec sleep 60\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    asked = threading.Event()
    with SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False) as server:
        server.register_function(lambda *_: (1, "", "http://127.0.0.1:1/"), "lookupNode")
        server.register_function(lambda *_: (asked.set(), (1, "", os.getpid()))[1], "getPid")
        monkeypatch.setattr(private_master, "free_port", lambda: server.server_address[1])
        monkeypatch.setattr(private_master, "START_TIMEOUT", 3.0)
        serving = threading.Thread(target=server.serve_forever)
        serving.start()
        try:
            with pytest.raises(PrivateMasterError, match="no ROS master at"), PrivateMaster():
                pass
        finally:
            server.shutdown()
            serving.join()
    assert asked.is_set()


def test_a_free_port_is_none_that_a_connection_may_be_given():
    with open("/proc/sys/net/ipv4/ip_local_port_range") as file:
        below = int(file.read().split()[0])
    ports = {free_port() for _ in range(5)}
    assert len(ports) > 1
    assert max(ports) < below or below <= private_master._LEAST_PORT


STARTER = """
import sys, time
from telex_experiments.rigs.private_master import PrivateMaster
with PrivateMaster() as master:
    print(master.uri, flush=True)
    time.sleep(60)
"""


@pytest.mark.ros
def test_a_master_does_not_outlive_a_starter_that_is_killed():
    with subprocess.Popen([sys.executable, "-c", STARTER], stdout=subprocess.PIPE) as starter:
        uri = starter.stdout.readline().decode().strip()
        tree = descendants(starter.pid)
        assert tree
        assert rosgraph.is_master_online(uri)
        starter.kill()
    wait_until(lambda: not any(map(is_running, tree)), "the master to end", 15.0)
