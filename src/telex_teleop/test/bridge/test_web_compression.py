"""Messages as rosbridge's compressions have them."""

from __future__ import annotations

import base64
import json
import math
import unittest.mock

import cbor2
import cv2
import numpy as np
import pytest
from bridge_bench import Bench, Client
from geometry_msgs.msg import PoseArray
from sensor_msgs.msg import CompressedImage, JointState
from std_msgs.msg import Header, Int8MultiArray, String, UInt32MultiArray
from web_fakes import on_loop

from telex_teleop.web.bridge.protocol.compression import ENCODERS, to_cbor, to_cbor_raw, to_png


def cbor(message):
    operation = cbor2.loads(to_cbor("/t", message))
    assert (operation["op"], operation["topic"]) == ("publish", "/t")
    return operation["msg"]


@pytest.mark.parametrize("length", [0, 1, 2, 3, 10, 1000, 20001])
def test_a_png_holds_the_json_in_its_pixels(length):
    text = json.dumps({"data": "ä" * length}, ensure_ascii=False)
    operation = json.loads(to_png(text))
    assert operation["op"] == "png"
    data = np.frombuffer(base64.b64decode(operation["data"]), np.uint8)
    pixels = cv2.imdecode(data, cv2.IMREAD_COLOR)[:, :, ::-1]  # as RGB
    assert pixels.tobytes().decode().rstrip("\n") == text


def test_cbor_has_arrays_as_their_bytes():
    state = JointState(Header(frame_id="x"), ["a"], [1.5, math.nan], [], [])
    state.header.stamp.secs, state.header.stamp.nsecs = 7, 8
    read = cbor(state)
    assert read["header"] == {"seq": 0, "stamp": {"secs": 7, "nsecs": 8}, "frame_id": "x"}
    assert read["name"] == ["a"]
    assert read["position"].tag == 86
    assert np.isnan(np.frombuffer(read["position"].value, "<f8")[1])
    assert cbor(CompressedImage(data=b"\x00\xff"))["data"] == b"\x00\xff"
    assert cbor(Int8MultiArray(data=[-1, 2]))["data"] == cbor2.CBORTag(72, b"\xff\x02")
    assert cbor(UInt32MultiArray(data=[2**32 - 1]))["data"].value == b"\xff" * 4
    assert cbor(PoseArray(poses=[]))["poses"] == []


def test_raw_cbor_has_the_message_as_ros_sends_it():
    operation = cbor2.loads(to_cbor_raw("/t", String("word")))
    assert operation["msg"] == {"secs": 0, "nsecs": 0, "bytes": b"\x04\0\0\0word"}


@on_loop
async def test_clients_get_what_they_ask_for():
    bench = Bench()
    plain, compact = Client(bench), Client(bench)
    plain.say("subscribe", topic="/known", compression="none")
    compact.say("subscribe", topic="/known", id="a", compression="png")
    compact.say("subscribe", topic="/known", id="b", compression="cbor")
    await bench.settle()
    bench.ros.receivers["/known"](String("word"), None)
    assert (await plain.hear())["msg"] == {"data": "word"}
    assert cbor2.loads(await compact.outbox.get())["msg"] == {"data": "word"}
    compact.say("unsubscribe", topic="/known", id="b")
    bench.ros.receivers["/known"](String("word"), None)
    assert (await compact.hear())["op"] == "png"
    bench.ros.receivers["/known"](String("x" * 70000), None)
    assert (await compact.hear())["op"] == "publish"  # too long to be packed while others wait
    compact.say("subscribe", topic="/known", compression="zip", id="c")
    reason = "subscribe: there is no compression 'zip'; known are none, png, cbor, cbor-raw"
    assert (await compact.hear())["msg"] == reason


@on_loop
async def test_a_message_that_cannot_be_encoded_for_one_reaches_the_others():
    bench = Bench()
    broken, plain = Client(bench), Client(bench)
    broken.say("subscribe", topic="/known", compression="cbor")
    plain.say("subscribe", topic="/known")
    await bench.settle()
    with unittest.mock.patch.dict(ENCODERS, {"cbor": lambda topic, message: 1 / 0}):
        for word in ("one", "two"):
            bench.ros.receivers["/known"](String(word), None)
        await bench.settle()
    assert [(await plain.hear())["msg"]["data"] for _ in range(2)] == ["one", "two"]
