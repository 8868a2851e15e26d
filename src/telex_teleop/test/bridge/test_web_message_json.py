"""rosbridge's JSON rules."""

from __future__ import annotations

import base64
import json
import math

import genpy
import pytest
from control_msgs.msg import JointJog
from geometry_msgs.msg import PoseArray, Twist, TwistStamped
from sensor_msgs.msg import CameraInfo, CompressedImage, JointState
from std_msgs.msg import (
    Bool,
    ByteMultiArray,
    Duration,
    Float32,
    Header,
    Int8,
    String,
    Time,
    UInt8,
    UInt8MultiArray,
    UInt64,
)
from std_srvs.srv import SetBool

from telex_teleop.web.bridge.protocol.ros_messages import FieldError, codec_of

NOW = genpy.Time(12, 34)


def read(message_class, value):
    return codec_of(message_class).from_json(value, lambda: NOW)


def write(message):
    return codec_of(type(message)).to_json(message)


def test_nested_messages_and_missing_fields():
    twist = read(Twist, {"linear": {"x": 0.5}})
    assert (twist.linear.x, twist.linear.y, twist.angular.z) == (0.5, 0.0, 0.0)


def test_integers_are_taken_for_floats():
    twist = read(Twist, {"linear": {"x": 1}})
    assert twist.linear.x == 1.0
    assert isinstance(twist.linear.x, float)


@pytest.mark.parametrize(
    ("message_class", "value", "said"),
    [
        (Int8, {"data": 1.0}, "data: expected an integer (int8), got a float"),
        (Int8, {"data": 128}, "data: int8 goes from -128 to 127"),
        (UInt8, {"data": -1}, "data: uint8 goes from 0 to 255"),
        (UInt8, {"data": True}, "data: expected an integer (uint8), got a boolean"),
        (UInt64, {"data": 2**64}, "data: uint64 goes"),
        (Bool, {"data": 1}, "data: expected true or false, got an integer"),
        (String, {"data": 1}, "data: expected a string, got an integer"),
        (String, {"data": "\ud800"}, "data: the string holds half of a surrogate pair"),
        (Twist, {"linear": {"x": "1"}}, "linear.x: expected a number, got a string"),
        (Twist, {"linear": None}, "linear: expected an object, got null"),
        (String, {"data": None}, "data: expected a string, got null"),
        (Twist, {"linear": {"x": True}}, "linear.x: expected a number, got a boolean"),
        (Twist, {"linear": {"x": math.inf}}, "linear.x: the number is not finite"),
        (Twist, {"linear": {"x": math.nan}}, "linear.x: the number is not finite"),
        (Twist, {"linear": {"x": 10**400}}, "linear.x: the number is not finite or too large"),
        (Float32, {"data": 1e39}, "data: the number is not finite or too large"),
        (Twist, {"linear": [1, 2, 3]}, "linear: expected an object, got a list"),
        (Twist, {"speed": 1}, "speed: geometry_msgs/Twist has no such field; its fields are"),
        (Twist, 7, "expected an object, got an integer"),
        (JointState, {"name": ["a", None]}, "name[1]: expected a string, got null"),
        (JointState, {"position": 1}, "position: expected a list, got an integer"),
        (PoseArray, {"poses": [{}, {"position": {"z": ""}}]}, "poses[1].position.z: expected"),
        (CameraInfo, {"K": [1.0]}, "K: expected 9 elements, got 1"),
        (Time, {"data": {"secs": -1}}, "data.secs: secs goes from 0"),
        (Time, {"data": {"nsecs": 10**9}}, "data.nsecs: nsecs goes from 0 to 999999999"),
        (Time, {"data": {"sec": 1}}, "data.sec: a time has secs and nsecs only"),
        (Time, {"data": 5}, 'data: expected {"secs", "nsecs"}, got an integer'),
        (Duration, {"data": "now"}, 'data: expected {"secs", "nsecs"}, got a string'),
        (UInt8MultiArray, {"data": "%%%"}, "data: the string is not base64"),
        (UInt8MultiArray, {"data": [256]}, "data[0]: uint8 goes from 0 to 255"),
    ],
)
def test_wrong_values_are_refused_with_the_path_of_their_field(message_class, value, said):
    with pytest.raises(FieldError) as error:
        read(message_class, value)
    assert str(error.value).startswith(said)


def test_numbers_that_are_not_finite_go_out_as_null():
    state = JointState(position=[1.0, math.nan, -math.inf])
    assert write(state)["position"] == [1.0, None, None]
    assert write(Float32(math.inf)) == {"data": None}
    json.dumps(write(state), allow_nan=False)
    came_back = read(JointState, write(state)).position
    assert came_back[0] == 1.0
    assert all(map(math.isnan, came_back[1:]))


def test_bytes_are_base64_and_signed_bytes_a_list():
    image = CompressedImage(format="jpeg", data=b"\x00\xff\x10")
    assert write(image)["data"] == base64.b64encode(b"\x00\xff\x10").decode()
    assert read(CompressedImage, {"data": "AP8Q"}).data == b"\x00\xff\x10"
    assert read(CompressedImage, {"data": [0, 255, 16]}).data == b"\x00\xff\x10"
    assert write(ByteMultiArray(data=[-1, 2]))["data"] == [-1, 2]
    assert write(UInt8MultiArray(data=[1, 2]))["data"] == "AQI="


def test_times():
    assert write(Time(genpy.Time(3, 4))) == {"data": {"secs": 3, "nsecs": 4}}
    assert read(Time, {"data": {"secs": 3}}).data == genpy.Time(3, 0)
    assert read(Time, {"data": "now"}).data == NOW
    assert read(Duration, {"data": {"secs": -3, "nsecs": 1}}).data == genpy.Duration(-3, 1)


def test_a_header_without_a_stamp_gets_the_present_time():
    assert read(Header, {}).stamp == NOW
    assert read(TwistStamped, {"header": {"frame_id": "base_link"}}).header.stamp == NOW
    given = {"header": {"stamp": {"secs": 1, "nsecs": 2}}}
    assert read(TwistStamped, given).header.stamp == genpy.Time(1, 2)
    assert read(TwistStamped, {}).header.stamp == genpy.Time()


def test_services_are_converted_like_messages():
    assert read(SetBool._request_class, {"data": True}).data is True
    answer = SetBool._response_class(success=True, message="ok")
    assert write(answer) == {"success": True, "message": "ok"}


@pytest.mark.parametrize(
    "message",
    [
        JointJog(joint_names=["turret_joint"], velocities=[-0.25], duration=0.5),
        CameraInfo(width=640, height=480, D=[0.1, 0.2], K=[float(i) for i in range(9)]),
        JointState(header=Header(3, genpy.Time(5, 6), "base_link"), name=["ä", "b"], effort=[2.5]),
    ],
)
def test_what_goes_out_comes_back(message):
    text = json.dumps(write(message), allow_nan=False)
    back = read(type(message), json.loads(text))
    assert write(back) == write(message)
    assert back.header == message.header
