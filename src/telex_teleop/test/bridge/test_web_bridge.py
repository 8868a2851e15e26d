"""The bridge's protocol, against a ROS that is played."""

from __future__ import annotations

import asyncio
import math

import pytest
from bridge_bench import JOG, TWIST, Bench, Client
from control_msgs.msg import JointJog
from geometry_msgs.msg import Twist, TwistStamped, Vector3
from std_msgs.msg import Header, String
from telex_msgs.msg import FlipperPresetHold
from waiting import wait_until_async
from web_fakes import on_loop

from telex_teleop.web.bridge.protocol.operations import MAX_DIGITS
from telex_teleop.web.bridge.topics.commands import stop_for

# Publishing


@on_loop
async def test_advertise_publish_unadvertise():
    bench = Bench()
    client = Client(bench)
    client.say("advertise", topic="chat", type="std_msgs/String", queue_size=5, latch=True)
    client.say("publish", topic="/telex/chat", msg={"data": "hello"})
    await bench.settle()
    assert bench.ros.events == [("advertise", "/telex/chat", "std_msgs/String", True, 5)]
    assert bench.ros.published == [("/telex/chat", String("hello"))]
    client.say("unadvertise", topic="chat")
    await wait_until_async(lambda: bench.ros.events[-1] == ("unregister", "/telex/chat"))
    assert len(client.outbox) == len(bench.publishers) == 0


@on_loop
async def test_the_first_messages_wait_for_the_subscribers_that_are_known():
    bench = Bench(connect_timeout=5.0)
    bench.ros.expected = 1
    client = Client(bench)
    client.say("advertise", topic="/x", type="std_msgs/String")
    client.say("publish", topic="/x", msg={"data": "1"})
    await bench.settle()
    client.say("publish", topic="/x", msg={"data": "2"})
    assert bench.ros.published == []
    bench.ros.connected = 1
    await bench.settle()
    assert [message.data for _, message in bench.ros.published] == ["1", "2"]


@on_loop
async def test_subscribers_that_do_not_connect_are_waited_for_only_so_long():
    bench = Bench(connect_timeout=0.05)
    bench.ros.expected = 1
    client = Client(bench)
    client.say("publish", topic="/known", msg={"data": "1"})
    await wait_until_async(lambda: bench.ros.published)
    assert [message.data for _, message in bench.ros.published] == ["1"]


@on_loop
async def test_publish_advertises_where_the_type_is_known():
    bench = Bench()
    client = Client(bench)
    client.say("publish", topic="/known", msg={"data": "x"}, id="p1")
    client.say("publish", topic="/nobody", msg={"data": "x"}, id="p2")
    status = await client.hear()
    assert (status["op"], status["level"], status["id"]) == ("status", "error", "p2")
    assert "nobody has published /nobody yet" in status["msg"]
    await bench.settle()
    assert bench.ros.published == [("/known", String("x"))]


@on_loop
async def test_a_type_that_is_not_the_topics_is_refused():
    bench = Bench()
    client = Client(bench)
    client.say("advertise", topic="/known", type=TWIST, id=3)
    status = await client.hear()
    assert status["id"] == 3
    assert status["msg"] == f"advertise: /known has the type std_msgs/String, not {TWIST}"
    bench.ros.active.discard("/known")  # of a type that nobody uses any more only the name is left
    client.say("advertise", topic="/known", type=TWIST)
    await bench.settle()
    assert bench.ros.events == [("advertise", "/known", TWIST, False, 100)]
    other = Client(bench)
    other.say("advertise", topic="/known", type="std_msgs/String")
    assert f"has the type {TWIST}" in (await other.hear())["msg"]


@pytest.mark.parametrize(
    "type_name", ["std_msgs/Nothing", "os/path", "std_msgs", "../x/Y", "a/b/c"]
)
def test_a_type_that_does_not_exist_is_refused(type_name):
    async def check():
        client = Client(Bench())
        client.say("advertise", topic="/new", type=type_name)
        assert type_name in (await client.hear())["msg"]

    asyncio.run(check())


@on_loop
async def test_messages_that_do_not_fit_are_dropped_with_a_reason():
    bench = Bench()
    client = Client(bench)
    client.say("advertise", topic="/v", type=TWIST)
    await bench.settle()
    for msg in ({"linear": {"x": "fast"}}, {"linear": None}, {"speed": 1}, 5):
        client.say("publish", topic="/v", msg=msg, id="bad")
        status = await client.hear()
        assert status["id"] == "bad"
        assert status["msg"].startswith("publish to /v: ")
    client.session.receive('{"op":"publish","topic":"/v","msg":{"linear":{"x":NaN}}}')
    assert "NaN is no JSON number" in (await client.hear())["msg"]
    client.session.receive('{"op":"publish","topic":"/v","msg":{"linear":{"x":1e999}}}')
    assert "linear.x: the number is not finite" in (await client.hear())["msg"]
    assert bench.ros.published == []


@on_loop
async def test_null_is_nan_where_nothing_moves_by_it():
    bench = Bench()
    client = Client(bench)
    for topic in ("/v", "v"):
        client.say("advertise", topic=topic, type=TWIST)
    await bench.settle()
    client.say("publish", topic="/v", msg={"linear": {"x": None}})
    ((topic, twist),) = bench.ros.published
    assert (topic, math.isnan(twist.linear.x), twist.linear.y) == ("/v", True, 0.0)
    client.say("publish", topic="v", msg={"linear": {"x": None}}, id="bad")
    status = await client.hear()
    said = "publish to /telex/v: a command holds null, which is no number to move by"
    assert (status["id"], status["msg"]) == ("bad", said)
    assert bench.control.holder is None
    assert len(bench.ros.published) == 1
    failed, why = await client.ask("switch", {"data": None})
    assert (failed, why) == (False, "a command holds null, which is no number to move by")


@on_loop
async def test_a_topic_of_another_type_is_answered_at_once():
    bench = Bench()
    client = Client(bench)
    client.say("advertise", topic="/v", type=TWIST)
    client.say("advertise", topic="/v", type="std_msgs/String", id="a")
    said = {"op": "status", "level": "error", "id": "a"}
    reason = f"this client publishes /v as {TWIST}, not std_msgs/String"
    assert await client.hear() == {**said, "msg": f"advertise: {reason}"}
    client.say("subscribe", topic="/known")
    await bench.settle()
    client.say("subscribe", topic="/known", type="std_msgs/String")
    client.say("subscribe", topic="/known", type=TWIST, id="a")
    reason = f"this client hears /known as std_msgs/String, not {TWIST}"
    assert await client.hear() == {**said, "msg": f"subscribe: {reason}"}
    await bench.settle()
    client.say("publish", topic="/v", msg={"linear": {"x": 1.0}})
    assert len(bench.ros.published) == 1


# What a client drove stops when it goes


@on_loop
async def test_a_client_that_vanishes_stops_what_it_drove():
    bench = Bench()
    client = Client(bench)
    client.say("advertise", topic="/drive", type=TWIST)
    client.say("advertise", topic="/jog", type=JOG)
    client.say("advertise", topic="/chat", type="std_msgs/String")
    client.say("publish", topic="/drive", msg={"linear": {"x": 1.0}})
    client.say("publish", topic="/jog", msg={"joint_names": ["a", "b"], "velocities": [0.1, 0]})
    client.say("publish", topic="/chat", msg={"data": "moving"})
    await bench.settle()
    del bench.ros.published[:]
    client.session.close()
    stops = dict(bench.ros.published)
    assert set(stops) == {"/drive", "/jog"}
    assert stops["/drive"] == Twist()
    assert (stops["/jog"].joint_names, stops["/jog"].velocities) == (["a", "b"], [0.0, 0.0])


@on_loop
async def test_a_client_that_stood_still_stops_nobody():
    bench = Bench()
    client = Client(bench)
    client.say("advertise", topic="/drive", type=TWIST)
    client.say("publish", topic="/drive", msg={"linear": {"x": 1.0}})
    client.say("publish", topic="/drive", msg={"linear": {"x": 0.0}})
    await bench.settle()
    del bench.ros.published[:]
    client.session.close()
    assert bench.ros.published == []


@on_loop
async def test_unadvertise_stops_as_well():
    bench = Bench()
    client = Client(bench)
    client.say("advertise", topic="/drive", type=TWIST)
    client.say("publish", topic="/drive", msg={"angular": {"z": 1.0}})
    await bench.settle()
    client.say("unadvertise", topic="/drive")
    assert bench.ros.published[-1] == ("/drive", Twist())


@on_loop
async def test_what_waits_for_its_publisher_goes_with_its_client():
    bench = Bench(connect_timeout=5.0)
    bench.ros.expected = 1
    client = Client(bench)
    client.say("advertise", topic="/drive", type=TWIST)
    client.say("publish", topic="/drive", msg={"linear": {"x": 1.0}})
    await bench.settle()
    client.session.close()
    bench.ros.connected = 1
    await bench.settle()
    assert bench.ros.published == []


@on_loop
async def test_operators_who_share_the_bridge_do_not_pass_for_one():
    bench = Bench()
    clients = [Client(bench), Client(bench)]
    for client in clients:
        client.say("advertise", topic="/presets", type="telex_msgs/FlipperPresetHold")
        # whatever it says of itself
        client.say("publish", topic="/presets", msg={"preset": "high", "client": "1"})
    await bench.settle()
    clients[1].session.close()
    sent = [(message.preset, message.client) for _, message in bench.ros.published]
    assert sent == [("high", "1"), ("high", "2"), ("", "2")]


@pytest.mark.parametrize(
    ("message", "stop"),
    [
        (Twist(linear=Vector3(x=0.1)), Twist()),
        (
            TwistStamped(header=Header(frame_id="tool_link"), twist=Twist(angular=Vector3(y=-1))),
            TwistStamped(header=Header(frame_id="tool_link")),
        ),
        (
            JointJog(joint_names=["a"], displacements=[0.1]),
            JointJog(joint_names=["a"], velocities=[0.0]),
        ),
        (JointJog(joint_names=["a"], velocities=[0.0]), None),
        (
            FlipperPresetHold(preset="high", joint_names=["a"], client="7"),
            FlipperPresetHold(client="7"),
        ),
        (FlipperPresetHold(), None),
        (Twist(), None),
        (String("x"), None),
    ],
)
def test_the_stop_for_a_command(message, stop):
    assert stop_for(message) == stop


# Subscribing


@on_loop
async def test_one_ros_subscription_serves_all_clients():
    bench = Bench()
    first, second = Client(bench), Client(bench)
    first.say("subscribe", topic="/known", id="a")
    second.say("subscribe", topic="known2", type="std_msgs/String")
    second.say("subscribe", topic="/known", type="std_msgs/String")
    await bench.settle()
    assert sorted(bench.ros.events) == [
        ("subscribe", "/known", "std_msgs/String"),
        ("subscribe", "/telex/known2", "std_msgs/String"),
    ]
    bench.ros.receivers["/known"](String("hi"), None)
    expected = {"op": "publish", "topic": "/known", "msg": {"data": "hi"}}
    assert await first.hear() == await second.hear() == expected
    bench.ros.receivers["/telex/known2"](String("there"), None)
    assert (await second.hear())["topic"] == "known2"
    first.say("unsubscribe", topic="/known", id="a")
    await bench.settle()
    assert ("unsubscribe", "/known") not in bench.ros.events
    second.session.close()
    await bench.settle()
    assert {("unsubscribe", "/known"), ("unsubscribe", "/telex/known2")} <= set(bench.ros.events)
    assert len(bench.subscribers) == 0


@on_loop
async def test_who_comes_later_gets_what_was_latched():
    bench = Bench()
    first, second = Client(bench), Client(bench)
    first.say("subscribe", topic="/known")
    await bench.settle()
    bench.ros.receivers["/known"](String("passing"), None)
    bench.ros.receivers["/known"](String("latched"), "/some_node")
    await bench.settle()
    second.say("subscribe", topic="/known")
    assert (await second.hear())["msg"] == {"data": "latched"}
    await bench.settle()
    assert len(second.outbox) == 0


@on_loop
async def test_messages_in_quick_succession_all_arrive_unless_a_length_is_asked_for():
    bench = Bench()
    patient, hasty = Client(bench), Client(bench)
    patient.say("subscribe", topic="/known")
    hasty.say("subscribe", topic="/known", queue_length=1)
    await bench.settle()
    for number in range(20):
        bench.ros.receivers["/known"](String(str(number)), None)
    await bench.settle()
    assert len(patient.outbox) == 20
    assert (await hasty.hear())["msg"] == {"data": "19"}
    assert len(hasty.outbox) == 0


@on_loop
async def test_of_a_burst_the_newest_is_heard_where_the_rate_is_limited():
    bench = Bench()
    client = Client(bench)
    client.say("subscribe", topic="/known", throttle_rate=3_600_000)
    await bench.settle()
    receive = bench.ros.receivers["/known"]
    for number in range(5):
        receive(String(str(number)), None)
    assert (await client.hear())["msg"] == {"data": "4"}
    for number in range(5, 8):
        receive(String(str(number)), None)
    await bench.settle()
    assert len(client.outbox) == 0
    # Another wish of the same client does not wait for the hour to be over.
    client.say("subscribe", topic="/known", id="all")
    assert (await client.hear())["msg"] == {"data": "7"}
    receive(String("8"), None)
    receive(String("9"), None)
    assert [(await client.hear())["msg"]["data"] for _ in range(2)] == ["8", "9"]


@on_loop
async def test_a_subscription_withdrawn_before_it_was_made_leaves_nothing():
    bench = Bench()
    client = Client(bench)
    client.say("subscribe", topic="/known", id=1)
    client.say("unsubscribe", topic="/known", id=1)
    await bench.settle()
    client.say("subscribe", topic="/known")
    client.session.close()
    await bench.settle()
    made = [event[0] for event in bench.ros.events]
    assert made.count("subscribe") == made.count("unsubscribe")
    assert len(bench.subscribers) == 0


@on_loop
async def test_a_client_may_not_subscribe_without_end():
    bench = Bench(max_subscriptions=3)
    client = Client(bench)
    for number in range(5):
        client.say("subscribe", topic=f"/t{number}", type="std_msgs/String")
        client.say("advertise", topic=f"/t{number}", type="std_msgs/String")
    await bench.settle()
    assert len(bench.subscribers) == len(bench.publishers) == 3
    sentences = {(await client.hear())["msg"] for _ in range(4)}
    assert sentences == {
        "subscribe: a client may subscribe to 3 topics at most",
        "advertise: a client may publish 3 topics at most",
    }


@on_loop
async def test_topics_that_cannot_be_subscribed_to_are_reported():
    client = Client(Bench())
    client.say("subscribe", topic="/nobody", id="s")
    assert (await client.hear())["msg"].startswith("subscribe: nobody has published /nobody yet")
    client.say("subscribe", topic="not a name")
    assert "no ROS name" in (await client.hear())["msg"]
    client.say("unsubscribe", topic="/never")
    assert (await client.hear())["msg"] == "unsubscribe: /never has not been subscribed to"


# Services


@on_loop
async def test_services_are_called_with_objects_and_lists():
    client = Client(Bench())
    good = (True, {"success": True, "message": "on"})
    assert await client.ask("/telex/switch", {"data": True}) == good
    assert await client.ask("switch", [True]) == good


@pytest.mark.parametrize(
    ("service", "args", "said"),
    [
        ("/nothing", {}, "there is no service /nothing"),
        ("switch", {"data": 1}, "data: expected true or false"),
        ("switch", [True, True], "the request has 1 fields, but 2 arguments came"),
        ("switch", 5, "'args' must be an object or a list"),
        ("switch", {"data": False}, "it is broken"),
        ("rosapi/nonsense", {}, "rosapi/nonsense is not offered"),
        ("rosapi/topic_type", {}, "'topic' must be a string"),
        ("rosapi/topic_type", 5, "'args' must be an object or a list"),
        ("rosapi/set_param", {"name": "x", "value": "{"}, "this is not valid JSON"),
        ("rosapi/set_param", {"name": "x", "value": 1}, "'value' must be a string that holds"),
        ("rosapi/set_param", {"name": "x", "value": "null"}, "cannot hold this value"),
        (
            "rosapi/set_param",
            {"name": "/", "value": "{}"},
            "/ holds all parameters of the robot; name a",
        ),
        ("rosapi/set_param", {"name": "/telex", "value": "{}"}, "/telex holds all parameters"),
        ("rosapi/delete_param", {"name": "/telex/"}, "/telex/ holds all parameters"),
        ("rosapi/delete_param", {"name": "/absent"}, "the parameter /absent is not set"),
    ],
)
def test_calls_that_fail_say_why(service, args, said):
    async def check():
        succeeded, values = await Client(Bench()).ask(service, args)
        assert succeeded is False
        assert said in values

    asyncio.run(check())


@on_loop
async def test_a_service_that_takes_its_time_holds_up_nobody_and_is_given_up():
    bench = Bench(service_timeout=0.2, max_service_calls=1)
    bench.ros.release_service.clear()
    client = Client(bench)
    client.say("call_service", service="switch", args={"data": True}, id="slow")
    client.say("call_service", service="switch", args={"data": True}, id="too many")
    refused = await client.hear()
    assert (refused["id"], refused["result"]) == ("too many", False)
    assert await Client(bench).ask("rosapi/nodes") == (True, {"nodes": ["/telex/arm_teleop"]})
    late = await client.hear()
    assert (late["id"], late["result"]) == ("slow", False)
    assert "did not answer within 0.2 s" in late["values"]
    bench.ros.release_service.set()


@on_loop
async def test_rosapi():
    bench = Bench()
    bench.ros.active.add("/silent")
    client = Client(bench)
    ask = client.ask
    assert await ask("/rosapi/topics") == (
        True,
        {
            "topics": ["/known", "/silent", "/telex/joint_states"],
            "types": ["std_msgs/String", "", "sensor_msgs/JointState"],
        },
    )
    states = {"type": "sensor_msgs/JointState"}
    for spelled in ("/telex/joint_states", "joint_states", "telex/joint_states"):
        assert await ask("rosapi/topic_type", {"topic": spelled}) == (True, states)
    assert await ask("rosapi/topic_type", ["/absent"]) == (True, {"type": ""})
    services = (await ask("rosapi/services"))[1]["services"]
    assert {"/telex/switch", "/rosapi/get_time", "/telex/bridge/take_control"} <= set(services)
    assert "/telex/bridge/end_exam" in services
    assert len(services) == len(set(services)) == 33
    kind = {"type": "std_srvs/SetBool"}
    assert await ask("rosapi/service_type", {"service": "/telex/switch"}) == (True, kind)
    assert await ask("rosapi/get_time") == (True, {"time": {"secs": 7, "nsecs": 8}})
    assert await ask("rosapi/get_param", {"name": "limit"}) == (True, {"value": "1.5"})
    assert await ask("rosapi/get_param", {"name": "nan"}) == (True, {"value": "null"})
    assert await ask("rosapi/get_param", {"name": "/absent"}) == (True, {"value": "null"})
    default = {"name": "/absent", "default": "3"}
    assert await ask("rosapi/get_param", default) == (True, {"value": "3"})
    value = {"name": "/new", "value": '{"a": [1, 2.5, "x"]}'}
    assert await ask("rosapi/set_param", value) == (True, {})
    assert bench.ros.params["/new"] == {"a": [1, 2.5, "x"]}
    assert await ask("rosapi/delete_param", {"name": "/new"}) == (True, {})
    names = {"names": ["/nan", "/telex/limit"]}
    assert await ask("rosapi/get_param_names") == (True, names)


# Nonsense


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "this is not valid JSON"),
        ("{", "this is not valid JSON"),
        ("nonsense", "this is not valid JSON"),
        ("[1]", "a message must be a JSON object with an 'op'"),
        ('"op"', "a message must be a JSON object"),
        ("{}", "'op' must be a string that is not empty"),
        ('{"op": 5}', "'op' must be a string"),
        ('{"op": "fly"}', "fly: there is no operation 'fly'; known are publish, advertise"),
        ('{"op": "publish"}', "publish: 'topic' must be a string"),
        ('{"op": "advertise", "topic": "/x"}', "advertise: 'type' must be a string"),
        ('{"op": "unadvertise", "topic": "/x"}', "unadvertise: /x has not been advertised"),
        ('{"op": "subscribe", "topic": ["/x"]}', "subscribe: 'topic' must be a string"),
        (
            '{"op": "subscribe", "topic": "/known", "throttle_rate": -1}',
            "subscribe: 'throttle_rate' must be a whole number from 0 on",
        ),
        ('{"op": "subscribe", "topic": "/known", "queue_length": "9"}', "'queue_length' must be"),
        ('{"op": "subscribe", "topic": "/known", "queue_length": 1e999}', "'queue_length' must be"),
        (
            '{"op": "advertise", "topic": "/x", "type": "std_msgs/String", "latch": 1}',
            "advertise: 'latch' must be true or false",
        ),
        ('{"op": "call_service"}', "call_service: 'service' must be a string"),
        ('{"op": "set_level", "level": "loud"}', "set_level: there is no level 'loud'"),
        ('{"op": "publish", "topic": NaN}', "NaN is no JSON number"),
        (f'{{"op": "publish", "id": {"9" * (MAX_DIGITS + 2)}}}', "too many digits"),
        ("[" * 100000, "the JSON is nested too deeply"),
        ('{"op":' * 100000, "the JSON is nested too deeply"),
    ],
)
def test_nonsense_is_answered_and_moves_nothing(text, said):
    async def check():
        bench = Bench()
        client = Client(bench)
        client.session.receive(text)
        status = await client.hear()
        assert (status["op"], status["level"]) == ("status", "error")
        assert said in status["msg"]
        await bench.settle()
        assert bench.ros.published == bench.ros.events == []
        assert await client.ask("rosapi/nodes") == (True, {"nodes": ["/telex/arm_teleop"]})

    asyncio.run(check())


@on_loop
async def test_a_client_can_ask_not_to_hear_of_errors():
    client = Client(Bench())
    client.say("set_level", level="none")
    client.say("fly")
    client.say("status", level="info", msg="x")
    assert len(client.outbox) == 0
    client.say("set_level", level="error")
    client.say("fly", id="x")
    assert (await client.hear())["id"] == "x"


@on_loop
async def test_a_client_that_reads_no_answers_is_dropped():
    client = Client(Bench())
    for _ in range(1001):
        client.say("fly")
    assert len(client.dropped) == 1
