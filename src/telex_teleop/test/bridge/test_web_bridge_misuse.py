"""The bridge before clients that mean it ill: nothing crashes, nothing moves, errors say why."""

from __future__ import annotations

import asyncio
import json
import random
import sys

import aiohttp
import pytest
from bridge_bench import Bench, Client
from waiting import wait_until_async
from web_fakes import HUNG, FakeRos, on_loop, served

from telex_teleop.web.bridge.bridge_app import Rosbridge
from telex_teleop.web.server_config import RosbridgeConfig

DRIVE = "/telex/track_teleop/cmd_vel"
NAMES = ("op", "id", "topic", "type", "msg", "service", "args", "values", "result", "level", "sent")
OPERATIONS = (
    *("advertise", "unadvertise", "publish", "subscribe", "unsubscribe", "call_service"),
    *("advertise_service", "unadvertise_service", "service_response", "set_level", "status"),
    *("fragment", "png", "auth", "advertise_action", "", "\x00", "é" * 600),
)


def nonsense(dice, depth=0):
    """Return a value of any kind that JSON knows, and some that it does not."""
    kinds = [
        lambda: None,
        lambda: dice.choice([True, False]),
        lambda: dice.choice([0, -1, 2**31, 2**63, 2**64, -(2**63), 10**19]),
        lambda: dice.choice([0.5, -1e308, 1e308, float("nan"), float("inf"), 5e-324]),
        lambda: dice.choice(
            ["", "/", "//", "~x", "a b", "\ud800", "\x00", "../..", "é" * 99, "x" * 5000]
        ),
        lambda: dice.choice(["/known", DRIVE, "std_msgs/String", "geometry_msgs/Twist", "os/path"]),
        lambda: dice.choice(["switch", "rosapi/topics", "rosapi/set_param", "bridge/hand_over"]),
    ]
    if depth < 4:
        kinds += [
            lambda: [nonsense(dice, depth + 1) for _ in range(dice.randrange(4))],
            lambda: {
                dice.choice(["linear", "x", "data", "name", "value", "secs", ""]): nonsense(
                    dice, depth + 1
                )
                for _ in range(dice.randrange(4))
            },
        ]
    return dice.choice(kinds)()


@on_loop
async def test_any_nonsense_is_survived():
    """Operations with fields of any type; whatever is published by them is a valid message."""
    bench = Bench(connect_timeout=0.0, service_timeout=0.2)
    dice = random.Random(8)
    clients = [Client(bench) for _ in range(4)]
    for _ in range(4000):
        fields = {name: nonsense(dice) for name in dice.sample(NAMES, dice.randrange(6))}
        fields["op"] = dice.choice(OPERATIONS) if dice.random() < 0.95 else nonsense(dice)
        text = json.dumps(fields)
        if dice.random() < 0.1:
            cut = dice.randrange(len(text))
            text = text[:cut] + dice.choice(["", "}", "\x00", "[", '"', "NaN"]) + text[cut + 1 :]
        client = dice.choice(clients)
        client.session.receive(text)
        await asyncio.sleep(0)
        while len(client.outbox):
            assert json.loads(await client.outbox.get())["op"] in (
                *("status", "service_response", "publish"),
            )
    await bench.settle()
    moved = [message for topic, message in bench.ros.published if topic == DRIVE]
    assert all(message.linear.x == 0.0 for message in moved)
    sane = Client(bench)
    assert (await sane.ask("rosapi/get_time"))[0]
    for client in clients:
        client.session.close()
    assert bench.control.members == [sane.member]
    await wait_until_async(lambda: len(bench.subscribers) == len(bench.publishers) == 0)


@pytest.mark.parametrize(
    "text",
    [
        '{"op":"publish","topic":"/known","msg":{"data":%s}}' % ("[" * 500 + "]" * 500),
        '{"op":"publish","topic":"/known","msg":%s}' % ('{"a":' * 500 + "1" + "}" * 500),
        '{"op":"call_service","service":"switch","args":%s}' % ("[" * 900 + "]" * 900),
        '{"op":"publish","topic":"/known","msg":{"data":"\\ud800"}}',
        '{"op":"publish","topic":"/known","msg":{"data":"x"},"msg":5}',
        '{"op":"publish","topic":"%s","msg":{}}' % ("/x" * 100000),
        '{"op":"subscribe","topic":"/known","throttle_rate":1e300}',
        '{"op":"advertise_service","service":"switch","type":"std_srvs/SetBool"}',
        '{"op":"advertise_service","service":"/rosapi/topics","type":"std_srvs/SetBool"}',
        '{"op":"advertise_service","service":"/x","type":"std_msgs/String"}',
        '{"op":"service_response","service":"/x","id":"y","values":{}}',
        '{"op":"unadvertise_service","service":"/x"}',
        '{"op":"fragment","id":"1","data":"{","num":0,"total":99999999}',
    ],
    ids=range(13),
)
def test_each_misuse_is_told(text):
    async def check():
        bench = Bench()
        client = Client(bench)
        client.session.receive(text)
        answer = await client.hear()
        assert answer["op"] == "status" or answer["result"] is False
        assert len(answer.get("msg") or answer["values"]) < 700
        await bench.settle()
        assert bench.ros.published == []
        assert len(client.outbox) == 0

    asyncio.run(check())


@on_loop
async def test_a_parameter_nested_without_end_is_refused():
    client = Client(Bench())
    for depth in (sys.getrecursionlimit() * 2, 100000):
        value = {"name": "/x", "value": "[" * depth + "]" * depth}
        succeeded, why = await client.ask("rosapi/set_param", value)
        assert not succeeded
        assert "nested too deeply" in why


def test_ten_thousand_subscriptions_and_a_flood_leave_the_operator_alone():
    async def check():
        ros = FakeRos()
        # Long, because aiohttp's client answers pings only while somebody reads from it.
        bridge = Rosbridge(RosbridgeConfig(ping_interval=600.0), ros, [].append)
        async with served(bridge.make_app(), "ws") as url, aiohttp.ClientSession() as http:
            greedy, operator = await http.ws_connect(url), await http.ws_connect(url)
            own = 1  # the bridge's, of training/exam
            await wait_until_async(lambda: len(bridge.shared.subscribers) == own)
            twist = {"topic": DRIVE, "type": "geometry_msgs/Twist"}
            await operator.send_json({"op": "advertise", **twist})
            heard = []

            async def listen():
                async for message in greedy:
                    heard.append(json.loads(message.data))

            listening = asyncio.ensure_future(listen())
            for number in range(10000):
                topic = {"topic": f"/t{number}", "type": "std_msgs/String"}
                await greedy.send_json({"op": "subscribe", **topic})
                if number % 1000 == 0:
                    value = {"linear": {"x": number + 1.0}}
                    await operator.send_json({"op": "publish", "topic": DRIVE, "msg": value})
            await wait_until_async(lambda: len(heard) == 9800, timeout=100.0)
            assert {answer["msg"] for answer in heard} == {
                "subscribe: a client may subscribe to 200 topics at most"
            }
            await wait_until_async(lambda: len(ros.published) == 10)
            assert [message.linear.x for _, message in ros.published] == [
                1000.0 * number + 1.0 for number in range(10)
            ]
            assert len(bridge.shared.subscribers) == own + 200
            await greedy.close()
            await listening
            await wait_until_async(lambda: len(bridge.shared.subscribers) == own)
            await operator.close()

    asyncio.run(asyncio.wait_for(check(), 120.0))


@on_loop
async def test_ten_thousand_wishes_for_one_topic_are_not_all_kept():
    bench = Bench(max_subscriptions=200)
    client = Client(bench)
    for number in range(10000):
        client.say("subscribe", topic="/known", id=f"s{number}")
        client.say("advertise", topic="/x", type="std_msgs/String", id=f"a{number}")
        while len(client.outbox):
            assert "a topic 200 times at most" in (await client.hear())["msg"]
    client.say("subscribe", topic="/known", id="s7", throttle_rate=5)  # one of those that it has
    assert len(client.outbox) == 0
    await bench.settle()
    assert len(bench.subscribers) == len(bench.publishers) == 1


@on_loop
async def test_who_takes_no_answers_is_not_heard_until_he_does():
    ros = FakeRos()
    config = RosbridgeConfig(send_buffer=4096, max_in_flight=16384, ping_interval=600.0)
    bridge = Rosbridge(config, ros, [].append)
    async with served(bridge.make_app(), "ws") as url, aiohttp.ClientSession() as http:
        deaf = await http.ws_connect(url)
        deaf._response.connection.transport.pause_reading()
        for _ in range(1500):
            await deaf.send_json({"op": "x" * 80})
        await asyncio.sleep(0.1)
        async with http.ws_connect(url) as other:
            await other.send_json({"op": "call_service", "service": "/rosapi/nodes"})
            assert (await other.receive_json(timeout=HUNG))["result"] is True
        deaf._response.connection.transport.resume_reading()
        for _ in range(1500):
            assert (await deaf.receive_json(timeout=HUNG))["op"] == "status"
        await deaf.close()
