#!/usr/bin/env python3
"""A ROS node that does what a test says: JSON objects as lines on stdin, answers on stdout.

It is a process of its own because rospy can be initialised only once per process, for one master.
Messages are read and written as YAML by genpy, not by the code under test.

    {"do": "subscribe", "topic", "type"}    then every message: {"topic", "time", "message"}
    {"do": "connected", "topic"}            whether a publisher has answered this subscriber
    {"do": "publish", "topic", "type", "message", ["latch", "hex": {field: text}, "rate"]}
    {"do": "publish_all", "orders"}         several such orders, one right after the other
    {"do": "subscribers", "topic", "type"}  how many are connected to this probe's publisher
    {"do": "serve", "service", "type", "response", ["delay", "held"]}
    {"do": "release", "service"}            let it answer, which is held until then
    {"do": "act", "server"}                 offer a telex_msgs/FlipperPreset action
    {"do": "unsubscribe", "topic"}
    {"do": "wait"}                          its answer comes after all that was said before
"""

from __future__ import annotations

import json
import sys
import threading
import time

import actionlib
import genpy
import rospy
import yaml
from telex_msgs.msg import FlipperPresetAction, FlipperPresetFeedback, FlipperPresetResult

from telex_control.ros.rospy_fixes.connecting import miss_nothing
from telex_control.ros.rospy_fixes.connections import has_answer


class Probe:
    def __init__(self):
        self.publishers = {}
        self.subscribers = {}
        self.services = {}
        self.released = {}
        self.repeated = {}
        self.lock = threading.Lock()

    def say(self, **news):
        with self.lock:
            sys.stdout.write(json.dumps(news) + "\n")
            sys.stdout.flush()

    def do_subscribe(self, topic, type):  # noqa: A002
        def heard(message):
            self.say(topic=topic, time=time.monotonic(), message=yaml.safe_load(str(message)))

        cls = genpy.message.get_message_class(type)
        self.subscribers[topic] = rospy.Subscriber(topic, cls, heard, tcp_nodelay=True)

    def do_connected(self, topic):
        return has_answer(self.subscribers[topic])

    def do_wait(self):
        pass

    def do_unsubscribe(self, topic):
        self.subscribers.pop(topic).unregister()

    def do_publish(self, topic, type, message=None, latch=False, hex=None, rate=0):  # noqa: A002
        publisher = self.publisher(topic, type, latch)
        filled = genpy.message.get_message_class(type)()
        genpy.message.fill_message_args(filled, [message or {}])
        for field, text in (hex or {}).items():
            setattr(filled, field, bytes.fromhex(text))
        self.repeated.pop(topic, None)
        if rate:
            self.repeated[topic] = filled
            threading.Thread(
                target=self.repeat, args=(topic, publisher, filled, rate), daemon=True
            ).start()
        else:
            publisher.publish(filled)

    def do_publish_all(self, orders):
        for order in orders:
            self.do_publish(**order)

    def repeat(self, topic, publisher, message, rate):
        due = time.monotonic()
        while self.repeated.get(topic) is message:
            if hasattr(message, "header"):
                message.header.stamp = rospy.Time.from_sec(time.time())
            publisher.publish(message)
            due += 1.0 / rate
            time.sleep(max(0.0, due - time.monotonic()))

    def publisher(self, topic, type, latch=False):  # noqa: A002
        if topic not in self.publishers:
            cls = genpy.message.get_message_class(type)
            self.publishers[topic] = rospy.Publisher(topic, cls, latch=latch, queue_size=10)
        return self.publishers[topic]

    def do_subscribers(self, topic, type):  # noqa: A002
        return self.publisher(topic, type).get_num_connections()

    def do_serve(self, service, type, response, delay=0.0, held=False):  # noqa: A002
        cls = genpy.message.get_service_class(type)
        released = self.released[service] = threading.Event()
        if not held:
            released.set()

        def answer(request):
            time.sleep(delay)
            self.say(service=service, request=yaml.safe_load(str(request)))
            released.wait()
            filled = cls._response_class()
            genpy.message.fill_message_args(filled, [response])
            return filled

        # Served anew, it answers something else from now on.
        if service in self.services:
            self.services.pop(service).shutdown()
        self.services[service] = rospy.Service(service, cls, answer)

    def do_release(self, service):
        self.released[service].set()

    def do_act(self, server):
        def execute(goal):
            # At once: who has sent a goal must not miss it. The result takes a way of its own.
            offered.publish_feedback(FlipperPresetFeedback(["a"], [0.5]))
            rospy.sleep(0.2)
            offered.set_succeeded(FlipperPresetResult(message=f"did {goal.preset}"))

        offered = actionlib.SimpleActionServer(server, FlipperPresetAction, execute, False)
        self.services[server] = offered
        offered.start()


def main():
    miss_nothing()
    rospy.init_node("probe", anonymous=True, disable_signals=True)
    probe = Probe()
    probe.say(answer="ready")
    for line in sys.stdin:
        order = json.loads(line)
        try:
            probe.say(answer=getattr(probe, "do_" + order.pop("do"))(**order))
        except Exception as error:
            probe.say(error=repr(error))
    rospy.signal_shutdown("done")


if __name__ == "__main__":
    main()
