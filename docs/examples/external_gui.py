#!/usr/bin/env python3
"""A GUI in little: shows the robot, drives it for two seconds, saves what its camera sees.

pip install roslibpy; python3 external_gui.py [--bridge-port 9090] [--video-port 8080]
"""

import argparse
import time
import urllib.request

import roslibpy

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--bridge-port", type=int, default=9090)
parser.add_argument("--video-port", type=int, default=8080)
parser.add_argument("--picture", default="front.jpg", help="where to save the picture")
options = parser.parse_args()

ros = roslibpy.Ros("127.0.0.1", options.bridge_port)
ros.run(timeout=10)  # afterwards it connects again by itself, and renews its subscriptions
newest = {}  # the newest message of each topic
for name, kind, period in (
    ("joint_states", "sensor_msgs/JointState", 100),  # at most every 100 ms
    ("sim/status", "telex_msgs/SimStatus", 0),
):
    topic = roslibpy.Topic(ros, f"/telex/{name}", kind, throttle_rate=period, queue_length=1)
    topic.subscribe(lambda message, name=name: newest.__setitem__(name, message))

tracks = roslibpy.Topic(ros, "/telex/track_teleop/cmd_vel", "geometry_msgs/Twist", queue_size=1)
tracks.advertise()
began = time.monotonic()
while time.monotonic() < began + 3.0:
    # A command holds for 0.25 s: it is repeated as long as a key would be held, then falls silent.
    if 0.5 < time.monotonic() - began < 2.5:
        tracks.publish(roslibpy.Message({"linear": {"x": 0.2}, "angular": {"z": 0.0}}))
    time.sleep(0.05)
states, status = newest["joint_states"], newest["sim/status"]
for joint, position in zip(states["name"], states["position"]):
    print(f"{joint:32} {position:8.3f}")
print("emergency stop:", "set" if status["e_stop"] else "released")

address = f"http://127.0.0.1:{options.video_port}/snapshot?topic=/telex/cameras/front/image_raw"
urllib.request.urlretrieve(address, options.picture)
ros.terminate()
