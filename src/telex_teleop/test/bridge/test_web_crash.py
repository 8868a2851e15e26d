"""What a server that was started again has in common with the one that crashed, and who is told."""

from __future__ import annotations

import re
import xmlrpc.client
from pathlib import Path
from xml.etree import ElementTree

import pytest
import rosgraph
from waiting import wait_until_async
from web_fakes import FakeRos, on_loop, served

from telex_teleop.web.bridge.bridge_app import Rosbridge
from telex_teleop.web.bridge.clients.other_robots import OtherRobots
from telex_teleop.web.bridge.ros_graph import RosGraph
from telex_teleop.web.bridge.status_topics import LOOKS_PER_LIST, NodeWatch
from telex_teleop.web.listening import bind, bind_again, url_of
from telex_teleop.web.server_config import RosbridgeConfig

PACKAGE = Path(__file__).resolve().parents[2]
INCLUDE = re.compile(r'<include file="\$\(find (\w+)\)/(\S+)"')
NODE = re.compile(r'<node [^>]*\bname="(\w+)"')


def launched(path):
    """Nodes of a launch file and of those that it includes."""
    text = path.read_text()
    names = set(NODE.findall(text))
    for package, file in INCLUDE.findall(text):
        names |= launched(PACKAGE.parent / package / file)
    return names


def test_the_console_knows_what_each_node_is_for():
    """One that it does not know would be called no part of the robot when it has crashed."""
    text = (PACKAGE / "console" / "js" / "health.js").read_text()
    known = set(re.findall(r'^  (\w+): term\("', text, re.MULTILINE))
    # Without rosbridge the console hears of nothing, and says so otherwise.
    assert known == launched(PACKAGE / "launch" / "bringup.launch") - {"rosbridge"}


def port_of(listener):
    return listener.getsockname()[1]


def test_a_server_comes_back_at_its_port():
    with bind("127.0.0.1", 0, "/v") as first:
        url, port = url_of("http", first), port_of(first)
    with bind_again("127.0.0.1", 0, "/v", url) as second:
        assert port_of(second) == port


def test_it_takes_another_one_if_somebody_has_it_now():
    with bind("127.0.0.1", 0, "/v") as taken, bind_again(
        "127.0.0.1", 0, "/v", url_of("http", taken)
    ) as second:
        assert port_of(second) != port_of(taken)


def test_a_port_that_is_asked_for_is_taken_whatever_was_before():
    with bind("127.0.0.1", 0, "/v") as probe:
        wanted = port_of(probe)
    with bind_again("127.0.0.1", wanted, "/v", "http://127.0.0.1:1") as second:
        assert port_of(second) == wanted


@pytest.mark.parametrize("left", [None, 3, "", "nonsense", "http://host", "http://host:99999999"])
def test_an_address_that_makes_no_sense_is_passed_over(left):
    with bind_again("127.0.0.1", 0, "/v", left) as listener:
        assert port_of(listener) > 0


def bridge(ros):
    return served(Rosbridge(RosbridgeConfig(), ros, lambda sentence: None).make_app(), "ws")


@on_loop
async def test_a_node_that_has_crashed_is_named_until_it_answers():
    ros = FakeRos()
    async with bridge(ros):
        await wait_until_async(lambda: ros.missing == [[]])
        ros.crashed.add("/telex/arm_teleop")
        await wait_until_async(lambda: ros.missing[-1] == ["/telex/arm_teleop"])
        ros.crashed.clear()
        await wait_until_async(lambda: ros.missing[-1] == [])
    # Nothing is repeated that has not changed.
    assert len(ros.missing) == 3


@on_loop
async def test_nodes_elsewhere_are_none_of_its_business():
    ros = FakeRos()
    ros.nodes = lambda: ["/other/arm_teleop", "/telex2/cameras", "/telex/cameras"]
    ros.crashed.update(ros.nodes())
    async with bridge(ros):
        await wait_until_async(lambda: ros.missing == [["/telex/cameras"]])


@pytest.mark.parametrize(
    "address",
    [
        None,
        "http://127.0.0.1:99999999/",
        "http://127.0.0.1:port/",
        f"http://{'a' * 70}:1234/",
        "http://[::1",
        "nonsense",
    ],
)
def test_a_node_whose_address_makes_no_sense_does_not_answer(address, monkeypatch):
    class Master:
        def __init__(self, caller):
            pass

        def lookupNode(self, node):  # noqa: N802 - rosgraph's name
            return address

    monkeypatch.setattr(rosgraph, "Master", Master)
    graph = RosGraph()
    assert not graph.node_answers("/telex/arm_teleop")
    assert graph._sent_by("/telex/arm_teleop") is None


@on_loop
async def test_what_is_wrong_with_one_node_hides_no_other():
    ros = FakeRos()
    ros.nodes = lambda: ["/telex/a", "/telex/b", "/telex/c"]
    answers = ros.node_answers

    def node_answers(node):
        if node == "/telex/a":
            raise ValueError("Port out of range")
        return answers(node)

    ros.node_answers = node_answers
    async with bridge(ros):
        await wait_until_async(lambda: ros.missing == [["/telex/a"]])
        ros.crashed.add("/telex/b")
        await wait_until_async(lambda: ros.missing[-1] == ["/telex/a", "/telex/b"])


@on_loop
async def test_the_watch_goes_on_after_a_look_that_failed():
    ros = FakeRos()
    nodes, failed = ros.nodes, []

    def failing_once():
        if not failed:
            failed.append(True)
            raise xmlrpc.client.ProtocolError("master", 500, "", {})
        return nodes()

    ros.nodes = failing_once
    async with bridge(ros):
        await wait_until_async(lambda: ros.missing == [[]])
    assert failed


def test_the_master_is_seldom_asked_which_nodes_there_are():
    ros = FakeRos()
    asked = []
    ros.nodes = lambda: asked.append("list") or ["/telex/a", "/other/b"]
    watch = NodeWatch(ros, None, OtherRobots("/telex/"))
    found = [watch._missing() for _ in range(LOOKS_PER_LIST)]
    ros.crashed.add("/telex/a")
    found.append(watch._missing())
    ros.crashed.clear()
    found.append(watch._missing())
    assert found == [[]] * LOOKS_PER_LIST + [["/telex/a"], []]
    assert len(asked) == 2


class SecondRobot(FakeRos):
    """As a further robot's bridge sees the master."""

    def resolve(self, name):
        return super().resolve(name).replace("/telex/", "/telex_b/")

    def advertise(self, topic, message_class, **options):
        return super().advertise(topic.replace("/telex_b/", "/telex/"), message_class, **options)

    def nodes(self):
        names = ("arm_teleop", "cameras", "rosbridge", "simulator", "video_server")
        return [*(f"/telex/{name}" for name in names), "/telex_b/arm_teleop"]


@on_loop
async def test_a_further_robot_is_told_of_the_nodes_that_serve_all():
    ros = SecondRobot()
    ros.crashed.update(ros.nodes())
    config = RosbridgeConfig(simulator="/telex")
    async with served(Rosbridge(config, ros, lambda sentence: None).make_app(), "ws"):
        await wait_until_async(lambda: ros.missing)
        serving = ["/telex/cameras", "/telex/simulator", "/telex/video_server"]
        assert ros.missing == [[*serving, "/telex_b/arm_teleop"]]


def test_a_simulator_in_no_namespace_serves_a_further_robot_as_well():
    ros = SecondRobot()
    ros.nodes = lambda: ["/arm_teleop", "/simulator", "/telex_b/arm_teleop"]
    ros.crashed.update(ros.nodes())
    watch = NodeWatch(ros, None, OtherRobots("/telex_b/"), "/")
    assert watch._missing() == ["/simulator", "/telex_b/arm_teleop"]


def test_a_further_robots_bridge_is_told_where_they_are():
    """After the bridge's own file, whose default would count else."""
    group = ElementTree.parse(PACKAGE / "launch" / "further_robot.launch").find("group")
    bridge, told = (
        next(at for at, each in enumerate(group) if part in ElementTree.tostring(each, "unicode"))
        for part in ("/launch/console.launch", 'name="rosbridge/simulator"')
    )
    assert bridge < told
    assert "arg('simulator')" in group[told].get("value")
