"""What a web page can send gets no answer from ROS; programs get theirs."""

from __future__ import annotations

import http.client
import os
import socket
import subprocess
import sys
import threading
import time
import xmlrpc.client
from pathlib import Path
from urllib.parse import urlsplit

import pytest
import rosgraph
import rosgraph.xmlrpc
from waiting import wait_until

from telex_control.common.child_processes import DIES_WITH_US
from telex_control.ros.rospy_fixes.xmlrpc_guard import (
    GuardedRequestHandler,
    guard_xmlrpc,
    is_own_host,
)
from telex_experiments.rigs.private_master import PrivateMaster, end_tree

pytestmark = pytest.mark.waiting

XML = {"Content-Type": "text/xml"}
NODE = """
import rospy
from std_msgs.msg import Empty
from telex_control.node_start import init_node
init_node("listener")
rospy.Subscriber("topic", Empty, lambda message: None)
rospy.spin()
"""


def post(url, body, headers, path="/"):
    """Send a request with just these headers, as a browser would; returns status and text."""
    address = urlsplit(url)
    connection = http.client.HTTPConnection(address.hostname, address.port, timeout=10.0)
    connection.putrequest("POST", path, skip_host=True, skip_accept_encoding=True)
    for name, value in {"Host": address.netloc, "Content-Length": len(body), **headers}.items():
        connection.putheader(name, value)
    connection.endheaders(body.encode())
    reply = connection.getresponse()
    text = reply.read().decode()
    connection.close()
    return reply.status, text


def call(method, *arguments):
    return xmlrpc.client.dumps(arguments, method)


@pytest.fixture
def server(monkeypatch):
    """Serve one method that counts its calls; yields its address and the calls."""
    handler = rosgraph.xmlrpc.SilenceableXMLRPCRequestHandler
    monkeypatch.setattr(rosgraph.xmlrpc, "SilenceableXMLRPCRequestHandler", handler)
    guard_xmlrpc()
    calls = []
    server = rosgraph.xmlrpc.ThreadingXMLRPCServer(("127.0.0.1", 0), 0)
    server.register_function(lambda text: calls.append(text) or "done", "move")
    thread = threading.Thread(target=server.serve_forever, args=(0.02,))
    thread.start()
    yield f"http://127.0.0.1:{server.server_address[1]}", calls
    server.shutdown()
    thread.join()
    server.server_close()


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({"Content-Type": "text/plain"}, 415),
        ({"Content-Type": "text/plain", "Origin": "https://evil.example"}, 403),
        ({"Content-Type": "text/xml", "Origin": "https://evil.example"}, 403),
        ({"Content-Type": "text/xml", "Origin": "null"}, 403),
        ({"Content-Type": "application/x-www-form-urlencoded"}, 415),
        ({"Content-Type": "multipart/form-data; boundary=text/xml"}, 415),
        ({}, 415),
        ({"Host": "evil.example", **XML}, 403),
        ({"Host": "evil.example:11311", **XML}, 403),
        ({"Host": "127.0.0.1.evil.example", **XML}, 403),
        ({"Host": "localhost@evil.example", **XML}, 403),
        ({"Host": "[evil", **XML}, 403),
        ({"Host": "", **XML}, 403),
    ],
)
def test_what_pages_send_is_refused(server, headers, status):
    url, calls = server
    assert post(url, call("move", "a"), headers)[0] == status
    assert calls == []


@pytest.mark.parametrize(
    "headers",
    [
        XML,
        {"Content-Type": "text/xml; charset=utf-8"},
        {"Content-Type": "Text/XML"},
        {"Host": "localhost:11311", **XML},
        {"Host": "LOCALHOST.", **XML},
        {"Host": "[::1]:11311", **XML},
        {"Host": "192.0.2.7", **XML},
        {"Host": socket.gethostname(), **XML},
        {"Host": f"{socket.gethostname()}.local:1", **XML},
    ],
)
def test_what_programs_send_is_answered(server, headers):
    url, calls = server
    assert post(url, call("move", "a"), headers)[0] == 200
    assert calls == ["a"]


@pytest.mark.parametrize("path", ["/", "/no/such/path"])
def test_a_request_hidden_in_another_one_is_not_read(server, path):
    url, calls = server
    hidden = call("move", "a")
    hidden = (
        f"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Type: text/xml\r\n"
        f"Content-Length: {len(hidden)}\r\n\r\n{hidden}"
    )
    page = {"Content-Type": "text/plain", "Origin": "https://evil.example"}
    for length in (0, len(hidden), "many", -1):
        assert post(url, hidden, {**page, "Content-Length": length}, path)[0] == 403
    time.sleep(0.2)
    assert calls == []


def test_names_that_ros_was_told_are_own(monkeypatch):
    assert not is_own_host("robot:11311")
    is_own_host.cache_clear()
    monkeypatch.setenv("ROS_HOSTNAME", "robot")
    assert is_own_host("robot:11311")
    is_own_host.cache_clear()
    monkeypatch.delenv("ROS_HOSTNAME")
    monkeypatch.setenv("ROS_MASTER_URI", "http://robot:11311/")
    assert is_own_host("Robot")
    is_own_host.cache_clear()


def test_the_guard_fits_what_rosgraph_makes_servers_of():
    assert issubclass(GuardedRequestHandler, rosgraph.xmlrpc.SimpleXMLRPCRequestHandler)


def test_every_node_of_the_workspace_begins_guarded():
    sources = Path(__file__).resolve().parents[3]
    begin = sorted(
        path.name
        for package in sources.glob("telex_*")
        if package.name != "telex_experiments"  # clients, on masters of their own
        for folder in ("src", "nodes", "scripts")
        for path in (package / folder).rglob("*")
        if path.is_file() and b"rospy.init_node(" in path.read_bytes()
    )
    assert begin == ["node_start.py"]


@pytest.mark.ros
def test_no_page_reaches_master_node_or_roslaunch():
    page = {"Content-Type": "text/plain", "Origin": "https://evil.example"}
    register = call(
        "registerPublisher", "/evil", "/telex/cmd_vel", "std_msgs/Empty", "http://127.0.0.1:1/"
    )
    with PrivateMaster() as master:
        node = subprocess.Popen(
            [*DIES_WITH_US, sys.executable, "-c", NODE],
            env=master.environment(),
            start_new_session=True,
        )
        try:
            asked = rosgraph.Master("/test", master_uri=master.uri)
            wait_until(lambda: "/listener" in str(asked.getSystemState()), "the node", 20.0)
            listener = asked.lookupNode("/listener")
            launches = list(asked.getParam("/roslaunch/uris").values())
            update = call("publisherUpdate", "/evil", "/topic", ["http://127.0.0.1:1/"])
            requests = [(master.uri, register), (listener, update)]
            requests += [(uri, call("get_pid")) for uri in launches]
            assert len(requests) == 3
            for uri, body in requests:
                for headers, status in (
                    (page, 403),
                    ({"Content-Type": "text/plain"}, 415),
                    ({"Host": "evil.example", **XML}, 403),
                ):
                    assert post(uri, body, headers)[0] == status, uri
            assert "/evil" not in str(asked.getSystemState())
            # roscpp's rosout has registered, and programs of all kinds are answered.
            for uri, body in requests:
                assert post(uri, body, XML)[0] == 200, uri
            for tool in (["rostopic", "list"], ["rosnode", "ping", "-c1", "/listener"]):
                subprocess.run(tool, env=master.environment(), check=True, stdout=-3, timeout=20.0)
        finally:
            end_tree(node)


def test_a_program_that_is_not_there_is_said(tmp_path):
    folder = os.path.join(os.path.dirname(__file__), "..", "..", "bin")
    python = os.path.dirname(sys.executable)
    done = subprocess.run(
        [os.path.join(folder, "roscore")],
        env={**os.environ, "PATH": f"{folder}:{python}"},
        capture_output=True,
        text=True,
        check=False,
        timeout=20.0,
    )
    assert done.returncode == 1
    assert done.stderr == (
        "roscore: there is no other program of this name on PATH; is ROS installed?\n"
    )
