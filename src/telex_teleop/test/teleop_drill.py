"""What the drills of the real nodes share: a fake robot, nodes as processes, keys that are held.

Messages are imported where they are needed: the tests that judge a drill do not need rospy.
"""

from __future__ import annotations

import contextlib
import subprocess
import sys
import threading
import time
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1]
TICK = 0.01  # s between joint states


class FakeRobot:
    """Publishes /clock and joint states; every joint is where its last reference says."""

    def __init__(self, joints):
        import rospy
        from rosgraph_msgs.msg import Clock
        from sensor_msgs.msg import JointState
        from std_msgs.msg import Float64

        self.joints = list(joints)
        self.positions = dict.fromkeys(joints, 0.1)
        self.history = []  # (sim time, positions), one per joint state
        self.messages = 0
        self.sim_time = 1.0
        self.paused = False
        self.each = None  # called with the stamp of every joint state, before it is published
        self._ended = False
        self._state = JointState
        self._clock_message = Clock
        self._clock = rospy.Publisher("/clock", Clock, queue_size=10)
        self._joint_states = rospy.Publisher("joint_states", JointState, queue_size=10)
        for joint in joints:
            topic = joint.replace("_joint", "_position_controller/command")
            rospy.Subscriber(
                topic, Float64, self._on_reference, callback_args=joint, tcp_nodelay=True
            )
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _on_reference(self, message, joint):
        self.positions[joint] = message.data
        self.messages += 1

    def _run(self):
        import rospy

        due = time.monotonic()
        while not self._ended:
            due += TICK
            time.sleep(max(0.0, due - time.monotonic()))
            if self.paused:
                continue
            self.sim_time = round(self.sim_time + TICK, 6)
            stamp = rospy.Time.from_sec(self.sim_time)
            state = self._state(name=self.joints, position=list(self.positions.values()))
            state.header.stamp = stamp
            self.history.append((self.sim_time, dict(self.positions)))
            if self.each is not None:
                self.each(stamp)
            self._clock.publish(self._clock_message(clock=stamp))
            self._joint_states.publish(state)

    def end(self):
        self._ended = True
        self._thread.join()

    def rate(self, joint, duration):
        """Mean velocity over the last `duration` seconds of sim time."""
        count = round(duration / TICK)
        (start, before), (end, after) = self.history[-count - 1], self.history[-1]
        return (after[joint] - before[joint]) / (end - start)


def description(joints):
    links = "".join(f'<link name="{joint}_link"/>' for joint in joints)
    parts = "".join(
        f'<joint name="{name}" type="{kind}"><parent link="base_link"/>'
        f'<child link="{name}_link"/>'
        f'<limit lower="{lower}" upper="{upper}" velocity="{velocity}" effort="1"/></joint>'
        for name, (kind, lower, upper, velocity) in joints.items()
    )
    return f'<robot name="fake"><link name="base_link"/>{links}{parts}</robot>'


class Node:
    """One of our nodes as a process."""

    def __init__(self, name):
        self.name = name
        self.start()

    def start(self):
        command = [str(PACKAGE / "nodes" / self.name)]
        # not our stdout: that carries the results, and its reader waits until everybody closes it
        self.process = subprocess.Popen(command, stdout=sys.stderr)

    def kill(self):
        self.process.kill()
        self.process.wait()

    def end(self):
        self.process.terminate()
        try:
            self.process.wait(10.0)
        except subprocess.TimeoutExpired:
            self.kill()


def repeat(publisher, message, duration):
    """Publish at 50 Hz, as a held key does."""
    end = time.monotonic() + duration
    while time.monotonic() < end:
        publisher.publish(message)
        time.sleep(0.02)


def wait_for(condition, what, timeout=60.0):
    """Wait until something is so, or raise a TimeoutError after `timeout` (s).

    A message that has not come yet (LookupError) counts as false.
    """
    deadline = time.monotonic() + timeout
    while True:
        with contextlib.suppress(LookupError):
            if condition():
                return
        if time.monotonic() > deadline:
            raise TimeoutError(what)
        time.sleep(0.01)


class Held:
    """Publishes at 50 Hz while something else is done."""

    def __init__(self, publisher, message):
        self._publisher, self._message = publisher, message
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def _run(self):
        while not self._ended.wait(0.02):
            self._publisher.publish(self._message)

    def __enter__(self):
        self._thread.start()

    def __exit__(self, *exception):
        self._ended.set()
        self._thread.join()
