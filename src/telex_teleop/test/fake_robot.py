"""A robot without physics for the real nodes: its joints are where their last references say."""

from __future__ import annotations

import contextlib
import statistics
import threading
import time
from pathlib import Path

from waiting import wait_until

from telex_teleop.motion.teleop_core import NEEDS_NEW_PRESS

PACKAGE = Path(__file__).resolve().parents[1]
TICK = 0.01  # s between joint states


class FakeRobot:
    """Publishes /clock and joint states; ends with its context."""

    def __init__(self, topics, joints):
        import rospy
        from rosgraph_msgs.msg import Clock
        from sensor_msgs.msg import JointState
        from std_msgs.msg import Float64

        self.joints = list(joints)
        self.positions = dict.fromkeys(joints, 0.1)
        self.history = []  # (sim time, positions), one per joint state
        self.references = {joint: [] for joint in joints}  # as they came: (monotonic time, value)
        self.messages = 0
        self.sim_time = 1.0
        self.paused = False
        self.each = None  # called with the stamp of every joint state, before it is published
        self._ended = False
        self._time = rospy.Time.from_sec
        self._state = JointState
        self._clock_message = Clock
        self._clock = topics.publisher("/clock", Clock)
        self._joint_states = topics.publisher("joint_states", JointState)
        for joint in joints:
            topic = joint.replace("_joint", "_position_controller/command")
            topics.subscriber(topic, Float64, self._on_reference, callback_args=joint)
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *exception):
        self._ended = True
        self._thread.join()

    def _on_reference(self, message, joint):
        self.positions[joint] = message.data
        self.references[joint].append((time.monotonic(), message.data))
        self.messages += 1

    def _run(self):
        due = time.monotonic()
        while not self._ended:
            # A delay is not made up for: the node would leave out all but the last of a burst.
            due = max(due + TICK, time.monotonic())
            time.sleep(max(0.0, due - time.monotonic()))
            if self.paused:
                continue
            self.sim_time = round(self.sim_time + TICK, 6)
            stamp = self._time(self.sim_time)
            state = self._state(name=self.joints, position=list(self.positions.values()))
            state.header.stamp = stamp
            self.history.append((self.sim_time, dict(self.positions)))
            if self.each is not None:
                self.each(stamp)
            self._clock.publish(self._clock_message(clock=stamp))
            self._joint_states.publish(state)

    def steps(self, joint, since=0):
        """Ways from each reference to the next with the time of that, from a reference on."""
        known = self.references[joint][max(0, since - 1) :]
        return [(moment, way - before) for (_, before), (moment, way) in zip(known, known[1:])]

    def travel(self, joint, action):
        """How far a joint moves while something is done."""
        before = self.positions[joint]
        action()
        return abs(self.positions[joint] - before)

    def rest(self, duration=0.32, timeout=20.0):
        """Wait until no joint has moved for a while (s) from now: longer than a command lives."""
        ticks = round(duration / TICK)
        begin = len(self.history) + ticks
        wait_until(
            lambda: (
                len(self.history) >= begin and self.history[-1][1] == self.history[-1 - ticks][1]
            ),
            "the robot at rest",
            timeout,
        )

    def put(self, positions, statuses):
        """Put joints somewhere, as if somebody had, and wait until a node's statuses tell so.

        A command that the node hears before it sees that ends by it.
        """
        statuses.clear()

        def seen():
            # again and again, for a reference may have been on its way
            self.positions.update(positions)
            status = statuses[-1]
            return dict(zip(status.joint_names, status.position)).items() >= positions.items()

        wait_until(seen, lambda: f"the node to tell {positions} (its status: {statuses[-1:]})")


def gaps(moments):
    """Times (s) from each to the next."""
    return [after - before for before, after in zip(moments, moments[1:])]


def rate(steps):
    """Velocity of a joint by its steps: their median.

    One comes for each joint state, so what holds them up on their way changes none.
    """
    return statistics.median(step for _, step in steps) / TICK


def description(joints):
    links = "".join(f'<link name="{joint}_link"/>' for joint in joints)
    parts = "".join(
        f'<joint name="{name}" type="{kind}"><parent link="base_link"/>'
        f'<child link="{name}_link"/>'
        f'<limit lower="{lower}" upper="{upper}" velocity="{velocity}" effort="1"/></joint>'
        for name, (kind, lower, upper, velocity) in joints.items()
    )
    return f'<robot name="fake"><link name="base_link"/>{links}{parts}</robot>'


def repeat(publisher, message, duration):
    """Publish at 50 Hz, as a held key does; returns when the last message went out (monotonic)."""
    with holding(publisher, message) as sent:
        time.sleep(duration)
    return sent[-1]


@contextlib.contextmanager
def holding(publisher, message):
    """Publish at 50 Hz while something else is done; gives the times when it was (monotonic)."""
    ended, sent = threading.Event(), []

    def publish():
        sent.append(time.monotonic())
        publisher.publish(message)

    def run():
        publish()
        while not ended.wait(0.02):
            publish()

    thread = threading.Thread(target=run)
    thread.start()
    try:
        yield sent
    finally:
        ended.set()
        thread.join()


@contextlib.contextmanager
def held_until(condition, what, publisher, message, statuses, anew=lambda: None):
    """Hold a key until something is so, and on until the caller's block ends; gives its times.

    It is pressed anew only where the node asks for that: to one that got no processor for half a
    second, what is held is from before.

    Parameters
    ----------
    what
        What is awaited, in words.
    statuses
        Of the node, as they come.
    anew
        Called between the node's asking and the next press: to forget what came before.
    """
    with contextlib.ExitStack() as held:
        sent = held.enter_context(holding(publisher, message))

        def done():
            nonlocal sent
            if condition():
                return True
            if statuses[-1].message == NEEDS_NEW_PRESS:
                held.close()
                wait_until(lambda: statuses[-1].message != NEEDS_NEW_PRESS, "the key to be let go")
                anew()
                sent = held.enter_context(holding(publisher, message))
            return False

        wait_until(done, lambda: f"{what} (the node's status: {statuses[-1:]})", 20.0)
        yield sent


def wait_until_told(statuses, message, speed_scale=1.0):
    """Wait until a node's status says that, at some speed."""
    told = message, speed_scale
    wait_until(
        lambda: (statuses[-1].message, statuses[-1].speed_scale) == told,
        lambda: f"the node to tell {told} (its status: {statuses[-1:]})",
    )


def wait_until_listening(statuses):
    """Wait until a node has joint states and the time is over in which it is deaf."""
    wait_until(
        lambda: not statuses[-1].message.startswith(("just started", "no joint")),
        lambda: f"the node to listen (its status: {statuses[-1:]})",
        60.0,
    )
