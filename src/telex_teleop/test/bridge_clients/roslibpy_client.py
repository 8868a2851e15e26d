"""An acceptance client: does with roslibpy what its own tests for ROS 1 do, and tells the outcome.

    roslibpy_client.py PORT NAME

Prints a JSON object: what came of each step. NAME tells apart what several clients do at a time.
"""

from __future__ import annotations

import json
import sys
import threading
import time

import roslibpy

try:
    from roslibpy.ros1 import actionlib
except ImportError:  # before roslibpy 2.1
    from roslibpy import actionlib

ACTION = "telex_msgs/FlipperPresetAction"
TIMEOUT = 30


class Steps:
    """One method per step; what it returns is its outcome."""

    def __init__(self, port, name):
        self.port, self.name = port, name
        self.ros = self.connect()

    def connect(self):
        ros = roslibpy.Ros("127.0.0.1", self.port)
        ros.run(TIMEOUT)
        return ros

    def topic(self):
        heard, enough = [], threading.Event()

        def hear(message):
            heard.append(message["data"])
            if len(heard) == 3:
                enough.set()

        listener = roslibpy.Topic(self.ros, f"/{self.name}/chat", "std_msgs/String")
        listener.subscribe(hear)
        self.ros.get_topics()  # answered after the subscription has been made
        talker = roslibpy.Topic(self.ros, f"/{self.name}/chat", "std_msgs/String")
        for word in ("one", "two", "three"):
            talker.publish(roslibpy.Message({"data": word}))
        assert enough.wait(TIMEOUT), heard
        listener.unsubscribe()
        talker.unadvertise()
        return heard

    def service(self):
        lamp = roslibpy.Service(self.ros, "/lamp", "std_srvs/SetBool")
        answer = lamp.call(roslibpy.ServiceRequest({"data": True}), timeout=TIMEOUT)
        absent = roslibpy.Service(self.ros, "/no_lamp", "std_srvs/SetBool")
        try:
            absent.call(roslibpy.ServiceRequest({"data": True}), timeout=TIMEOUT)
        except roslibpy.core.ServiceException as error:
            return [dict(answer), str(error)]
        raise AssertionError("a service that does not exist has answered")

    def offered_service(self):
        def serve(request, response):
            response["success"] = not request["data"]
            response["message"] = self.name
            return False  # as in roslibpy's own tests, where this is no failure

        service = roslibpy.Service(self.ros, f"/{self.name}/switch", "std_srvs/SetBool")
        service.advertise(serve)
        while service.name not in self.ros.get_services():
            time.sleep(0.02)
        other = self.connect()
        caller = roslibpy.Service(other, f"/{self.name}/switch", "std_srvs/SetBool")
        answer = dict(caller.call(roslibpy.ServiceRequest({"data": False}), timeout=TIMEOUT))
        service.unadvertise()
        other.close()
        return answer

    def parameter(self):
        param = roslibpy.Param(self.ros, f"/{self.name}/limits")
        param.set({"speed": 1.5})
        value = param.get()
        param.delete()
        return [value, param.get()]

    def graph(self):
        ros = self.ros
        details = ros.get_node_details("/telex/rosbridge")
        request = ros.get_service_request_details("std_srvs/SetBool")
        response = ros.get_service_response_details("std_srvs/SetBool")
        twist = ros.get_message_details("geometry_msgs/Twist")
        return {
            "topic": "/telex/bridge/clients" in ros.get_topics(),
            "topic_type": ros.get_topic_type("/telex/bridge/clients"),
            "topics_for_type": ros.get_topics_for_type("telex_msgs/BridgeClients"),
            "service": "/lamp" in ros.get_services(),
            "service_type": ros.get_service_type("/lamp"),
            "services_for_type": ros.get_services_for_type("std_srvs/SetBool"),
            "node": "/telex/rosbridge" in ros.get_nodes(),
            "publishing": "/telex/bridge/clients" in details["publishing"],
            "request": request["typedefs"][0]["fieldnames"],
            "response": response["typedefs"][0]["fieldtypes"],
            "message": [part["type"] for part in twist["typedefs"]],
            "time": ros.get_time()["secs"] > 0,
        }

    def action(self):
        client = actionlib.ActionClient(self.ros, f"/{self.name}/flippers", ACTION)
        goal = actionlib.Goal(client, roslibpy.Message({"preset": self.name}))
        feedback = []
        goal.on("feedback", feedback.append)
        goal.send()
        result = goal.wait(TIMEOUT)
        client.dispose()
        return [len(feedback) > 0, result["message"], goal.status["status"]]

    def action_server(self):
        name, kind = f"/{self.name}/server", ACTION
        server = actionlib.SimpleActionServer(self.ros, name, kind)

        def execute(goal):
            server.set_succeeded({"message": "did " + goal["preset"]})

        server.start(execute)
        self.ros.get_topics()
        other = self.connect()
        client = actionlib.ActionClient(other, name, kind)
        goal = actionlib.Goal(client, roslibpy.Message({"preset": "high"}))
        goal.send()
        result = goal.wait(TIMEOUT)
        other.close()
        return result["message"]


def main():
    roslibpy.set_rosapi_timeout(TIMEOUT)
    steps = Steps(int(sys.argv[1]), sys.argv[2])
    names = ["topic", "service", "offered_service", "parameter", "graph", "action", "action_server"]
    outcome = {name: getattr(steps, name)() for name in names}
    steps.ros.terminate()
    print(json.dumps(outcome), flush=True)


if __name__ == "__main__":
    main()
