import os
import subprocess
import threading
from pathlib import Path
from xmlrpc.server import SimpleXMLRPCServer

import pytest
from waiting import wait_until

from telex_control.ros.start_order import START_AFTER, wait_for_turn

FOREVER = 300.0
"""Longer than any test takes (s)."""
ROSVERSION = Path(__file__).resolve().parents[2] / "bin" / "rosversion"


@pytest.fixture
def known(monkeypatch):
    """What a master knows: nodes and topics; each question is noted under the key ''."""
    nodes = {"": []}

    def look_up(caller, name):
        nodes[""].append(name)
        return [1, "", "http://127.0.0.1:1"] if name in nodes else [-1, "unknown", ""]

    def published(caller, subgraph):
        nodes[""].append("topics")
        return [1, "", [[name, "std_msgs/Empty"] for name in nodes if name.endswith("image")]]

    with SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False) as server:
        server.register_function(look_up, "lookupNode")
        server.register_function(published, "getPublishedTopics")
        thread = threading.Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        monkeypatch.setenv("ROS_MASTER_URI", f"http://127.0.0.1:{server.server_address[1]}")
        yield nodes
        server.shutdown()
        thread.join()


@pytest.mark.parametrize(
    ("second", "asked", "comes"),
    [
        ("/a/cameras", "/a/cameras", "/a/cameras"),
        ("/a/cameras/", "topics", "/a/cameras/front/image"),
    ],
    ids=["a node", "a namespace"],
)
def test_it_waits_until_all_are_known(known, monkeypatch, second, asked, comes):
    monkeypatch.setenv(START_AFTER, f"/a/simulator {second}")
    known["/a/simulator"] = known["/other/image"] = True
    waiting = threading.Thread(target=wait_for_turn, args=(FOREVER,))
    waiting.start()
    wait_until(lambda: known[""].count(asked) >= 3, "the master to be asked", FOREVER)
    assert waiting.is_alive()
    known[comes] = True
    waiting.join(FOREVER)
    assert not waiting.is_alive()


def test_it_does_not_wait_for_ever(known, monkeypatch):
    monkeypatch.setenv(START_AFTER, "/never")
    wait_for_turn(0.2)
    assert "/never" in known[""]


def test_a_launch_that_is_ended_meanwhile_gets_no_traceback(known, monkeypatch):
    def interrupt(seconds):
        raise KeyboardInterrupt

    monkeypatch.setenv(START_AFTER, "/never")
    monkeypatch.setattr("telex_control.ros.start_order.time.sleep", interrupt)
    with pytest.raises(SystemExit):
        wait_for_turn(FOREVER)


def test_nobody_to_wait_for_is_nothing_to_ask(known, monkeypatch):
    monkeypatch.delenv(START_AFTER, raising=False)
    wait_for_turn(FOREVER)
    assert known[""] == []


def test_without_a_master_the_node_starts_and_says_what_is_wrong_itself(monkeypatch):
    monkeypatch.setenv(START_AFTER, "/simulator")
    for address in ("http://127.0.0.1:1", "no address", ""):
        monkeypatch.setenv("ROS_MASTER_URI", address)
        wait_for_turn(0.2)


def answer(*arguments, **variables):
    """What the workspace's rosversion prints."""
    return subprocess.run(
        [ROSVERSION, *arguments],
        env={**os.environ, **variables},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    ).stdout


def test_rosversion_answers_what_roslaunch_asks(tmp_path):
    assert answer("-d", ROS_DISTRO="some") == "some\n"
    package = tmp_path / "packages" / "roslaunch" / "package.xml"
    package.parent.mkdir(parents=True)
    package.write_text("<package>\n  <version>1.2.3</version>\n</package>\n")
    folders = f"{tmp_path / 'none'}:{tmp_path / 'packages'}"
    assert answer("roslaunch", ROS_PACKAGE_PATH=folders) == "1.2.3\n"


def test_rosversion_leaves_the_rest_to_the_next_one(tmp_path):
    other = tmp_path / "rosversion"
    other.write_text('#!/bin/sh\necho "asked $*"\n')
    other.chmod(0o755)
    path = f"{ROSVERSION.parent}:{tmp_path}:{os.environ['PATH']}"
    assert answer("rospy", PATH=path) == "asked rospy\n"
    assert answer("-d", PATH=path, ROS_DISTRO="") == "asked -d\n"
