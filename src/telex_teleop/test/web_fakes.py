"""Played ROS graphs for the tests of the web nodes, and a loop to run them on."""

from __future__ import annotations

import asyncio
import contextlib
import threading
import time

import genpy
from std_srvs.srv import SetBoolResponse

from telex_teleop.web.bridge.protocol.operations import OperationError
from telex_teleop.web.listening import bind, serve, url_of
from telex_teleop.web.video.topics import find_topic

HUNG = 30.0
"""Time (s) after which a wait has failed. At low priority, as most of these tests run, nothing can
be said of how soon something comes."""
HUNG_TEST = 120.0


def on_loop(check):
    """Make a test of a coroutine function."""

    def test():
        asyncio.run(asyncio.wait_for(check(), HUNG_TEST))

    test.__doc__ = check.__doc__
    return test


@contextlib.asynccontextmanager
async def served(app, scheme="http"):
    """Serve an application on a free port; gives its address."""
    listener = bind("127.0.0.1", 0, "test")
    stop, ready = asyncio.Event(), asyncio.Event()
    running = asyncio.ensure_future(serve(app, listener, stop, ready.set))
    try:
        await asyncio.wait_for(ready.wait(), HUNG)
        yield url_of(scheme, listener)
    finally:
        stop.set()
        await asyncio.wait_for(running, HUNG)


ROSTER = "/telex/bridge/clients"
"""What the bridge itself publishes; kept apart from what its clients do."""
MISSING_NODES = "/telex/bridge/missing_nodes"
LINK_STATE, LINK_CONFIGURE = "/telex/link/state", "/telex/link/configure"
EXAM = "/telex/bridge/exam"
OWN_TOPICS = (
    *(ROSTER, MISSING_NODES, LINK_STATE, EXAM, "/telex/e_stop"),
    "/telex/bridge/actions",
)


class FakePublisher:
    def __init__(self, ros, topic):
        self.ros = ros
        self.topic = topic

    def publish(self, message):
        if self.topic == ROSTER:
            self.ros.rosters.append(message)
        elif self.topic == MISSING_NODES:
            self.ros.missing.append(message.names)
        elif self.topic == LINK_STATE:
            self.ros.links.append(message)
        elif self.topic == EXAM:
            self.ros.exams.append(message.data)
        else:
            self.ros.published.append((self.topic, message))

    def connections(self):
        return self.ros.connected

    def unregister(self):
        self.ros.events.append(("unregister", self.topic))


class FakeRos:
    """A ROS graph that remembers what was asked of it."""

    def __init__(self):
        self.types = {"/known": "std_msgs/String", "/telex/joint_states": "sensor_msgs/JointState"}
        self.active = set(self.types)
        self.published = []
        self.rosters = []
        self.missing = []
        self.links = []
        self.exams = []
        self.events = []
        self.receivers = {}
        self.services_offered = {}
        self.params = {"/telex/limit": 1.5, "/nan": float("nan")}
        self.crashed = set()
        self.time = None  # sim time (s); None: that of the machine
        self.serving_takes = 0.0
        self.expected = 0
        self.connected = 0
        self.action_ready = True
        self.release_service = threading.Event()
        self.release_service.set()

    def now(self):
        return genpy.Time(7, 8)

    def sim_time(self):
        return time.monotonic() if self.time is None else self.time

    def resolve(self, name):
        if " " in name:
            raise OperationError(f"{name!r} is no ROS name")
        if name.startswith("~"):
            return f"/telex/rosbridge/{name[1:]}"
        return name if name.startswith("/") else f"/telex/{name}"

    def topic_types(self):
        return dict(self.types)

    def topics(self):
        return sorted(self.active)

    def nodes(self):
        return ["/telex/arm_teleop"]

    def node_answers(self, node):
        return node not in self.crashed

    def node_details(self, node):
        return {"subscribing": ["/known"], "publishing": [], "services": [node]}

    def services(self):
        return ["/telex/switch"]

    def service_nodes(self, service):
        return ["/telex/lamp"] if service == "/telex/switch" else []

    def service_host(self, service):
        return "lamp.example" if service == "/telex/switch" else ""

    def own_host(self):
        return "bridge.example"

    def publishers(self, topic):
        return []

    def subscribers(self, topic):
        return [f"/listener_{number}" for number in range(self.expected)]

    def action_connected(self, action):
        self.events.append(("ask", action))
        return self.action_ready

    def advertise(self, topic, message_class, *, latch, queue_size):
        if topic not in OWN_TOPICS:
            self.events.append(("advertise", topic, message_class._type, latch, queue_size))
        return FakePublisher(self, topic)

    def subscribe(self, topic, message_class, receive):
        self.events.append(("subscribe", topic, message_class._type))
        self.receivers[topic] = receive
        return lambda: self.events.append(("unsubscribe", topic))

    def service_type(self, service):
        known = service == "/telex/switch" or service in self.services_offered
        return "std_srvs/SetBool" if known else None

    def call_service(self, service, service_class, request):
        self.release_service.wait(5.0)
        if service in self.services_offered:
            return self.services_offered[service](request)
        if request.data:
            return SetBoolResponse(success=True, message="on")
        raise OperationError("it is broken")

    def serve(self, service, service_class, answer):
        if service == "/telex/switch":
            raise OperationError(f"{service} is offered by /telex/lamp already")
        time.sleep(self.serving_takes)
        self.services_offered[service] = answer
        return lambda: self.services_offered.pop(service)

    def get_param(self, name):
        return self.params[name]

    def set_param(self, name, value):
        if value is None:
            raise TypeError("cannot marshal None")
        self.params[name] = value

    def delete_param(self, name):
        del self.params[name]

    def param_names(self):
        return list(self.params)


class FakePictures:
    """Image topics that a test feeds by hand."""

    def __init__(self, topics):
        self.published = dict(topics)
        self.params = {}
        self.receivers = {}
        self.events = []
        self.down = False
        self.time = None  # sim time (s); None: that of the machine

    def sim_time(self):
        return time.monotonic() if self.time is None else self.time

    def topics(self):
        if self.down:
            raise ConnectionRefusedError("no master")
        return dict(self.published)

    def find(self, topic, *, raw=False):
        return find_topic(topic, self.topics(), "/telex/", raw=raw)

    def subscribe(self, topic, receive):
        self.events.append(("subscribe", topic.name))
        self.receivers[topic.name] = receive

        def unsubscribe():
            self.events.append(("unsubscribe", topic.name))
            del self.receivers[topic.name]

        return unsubscribe

    def parameter(self, name):
        return self.params.get(name)

    def feed(self, topic, picture):
        """Hand over a picture from another thread, as rospy does."""
        thread = threading.Thread(target=self.receivers[topic], args=(picture,))
        thread.start()
        return thread
