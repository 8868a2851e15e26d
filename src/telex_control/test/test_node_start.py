"""Nodes end when they are told to, whatever their main thread is doing; loops are not held up."""

from __future__ import annotations

import gc
import signal
import subprocess
import sys

import pytest
import rospy

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
