"""Nodes end when they are told to, whatever their main thread is doing; loops are not held up."""

from __future__ import annotations

import gc
import signal
import subprocess
import sys

import pytest
import rospy
from waiting import wait_until

from telex_control.common import interpreter
from telex_control.ros import node_start
from telex_control.ros.node_start import until_shutdown
from telex_experiments.rigs.private_master import PrivateMaster

pytestmark = pytest.mark.waiting

# Is told to end while it talks to the master: rospy's lock of that connection is taken.
NODE = """
import os, signal, sys, time
import rospy
from rospy.core import xmlrpcapi
from std_msgs.msg import Empty
from telex_control.node_start import init_node
init_node("node")
rospy.on_shutdown(lambda: print("hook ran", flush=True))
publisher = rospy.Publisher("topic", Empty, queue_size=1)  # something to take back at the end
with xmlrpcapi(rospy.core.rosgraph.get_master_uri())._lock:
    os.kill(os.getpid(), int(sys.argv[1]))
    time.sleep(0.2)
rospy.spin()
print("spin returned", flush=True)
"""


# The timer's thread of actionlib is held up where it asks whether the node is shut down.
ACTIONS = """
import threading, time
import actionlib, rospy
from control_msgs.msg import FollowJointTrajectoryAction as Action
from rospy.topics import get_topic_manager
from telex_control.ros.node_start import end_quietly, init_node
init_node("node")
rospy.loginfo("said at once")
server = actionlib.ActionServer("action", Action, print, print, auto_start=False)
server.start()
end_quietly(server)
asked = threading.Event()
really = rospy.is_shutdown
def slowly():
    answer = really()
    if "publish_status" in threading.current_thread().name and not asked.is_set():
        asked.set()
        until = time.monotonic() + 1.0
        while not get_topic_manager().closed and time.monotonic() < until:
            time.sleep(0.01)
    return answer
publish = server.publish_status_async
def named(event):
    threading.current_thread().name = "publish_status"
    publish(event)
server.status_timer._callback = named
rospy.is_shutdown = slowly
rospy.core.add_preshutdown_hook(lambda reason: time.sleep(1.0))  # closed, not yet shut down
asked.wait(10.0)
rospy.signal_shutdown("over")
"""


@pytest.mark.ros
def test_an_action_server_says_nothing_while_its_node_shuts_down():
    with PrivateMaster() as master:
        result = subprocess.run(
            [sys.executable, "-c", ACTIONS],
            env=master.environment(),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=30.0,
            check=False,
            text=True,
        )
    assert result.returncode == 0, result.stdout
    assert "Traceback" not in result.stdout


@pytest.mark.ros
def test_what_a_node_says_is_in_a_file_at_once(tmp_path):
    said = tmp_path / "said.txt"
    program = ACTIONS.split("server =")[0] + "time.sleep(60.0)"
    with PrivateMaster() as master, said.open("w") as output:
        environment = dict(master.environment(), PYTHONUNBUFFERED="")
        node = subprocess.Popen([sys.executable, "-c", program], env=environment, stdout=output)
        try:
            wait_until(lambda: "said at once" in said.read_text(), "what the node says", 30.0)
        finally:
            node.kill()
            node.wait()


@pytest.mark.ros
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_node_that_talks_to_the_master_ends(number):
    with PrivateMaster() as master:
        result = subprocess.run(
            [sys.executable, "-c", NODE, str(int(number))],
            env=master.environment(),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=30.0,
            check=False,
            text=True,
        )
    assert result.returncode == 0, result.stdout
    assert "hook ran" in result.stdout
    assert "spin returned" in result.stdout


def test_a_loop_may_find_its_topics_closed_by_the_shutdown(monkeypatch):
    monkeypatch.setattr(node_start, "is_shutdown_requested", lambda: True)
    with until_shutdown():
        raise rospy.ROSException("publish() to a closed topic")
    monkeypatch.setattr(node_start, "is_shutdown_requested", lambda: False)
    with pytest.raises(rospy.ROSException), until_shutdown():
        raise rospy.ROSException("publish() to a closed topic")


def test_full_collections_leave_out_what_was_there_before():
    interval = sys.getswitchinterval()
    try:
        interpreter.prepare_for_loop()
        assert sys.getswitchinterval() == pytest.approx(interpreter.SWITCH_INTERVAL)
        assert len(gc.get_objects()) < 0.01 * gc.get_freeze_count()
    finally:
        sys.setswitchinterval(interval)
        gc.unfreeze()
