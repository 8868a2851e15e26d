"""What waits for a client of the bridge, and how often it wants to hear of a topic."""

from __future__ import annotations

import asyncio

import pytest
from std_msgs.msg import Int32
from waiting import wait_until_async

from telex_teleop.web.bridge.clients.outbox import Outbox, OutboxFullError
from telex_teleop.web.bridge.protocol.compression import TopicMessage
from telex_teleop.web.bridge.protocol.ros_messages import codec_of
from telex_teleop.web.bridge.topics.subscribe import ClientSubscription, Wish


def run(coroutine):
    return asyncio.run(asyncio.wait_for(coroutine, 10.0))


async def taken(outbox):
    return [await outbox.get() for _ in range(len(outbox))]


def test_messages_leave_in_the_order_they_came():
    async def check():
        outbox = Outbox(1000)
        outbox.put_message("a", "a1", 10)
        outbox.put_reply("reply")
        outbox.put_message("b", "b1", 10)
        outbox.put_message("a", "a2", 10)
        assert await taken(outbox) == ["a1", "reply", "b1", "a2"]
        assert len(outbox) == 0

    run(check())


def test_the_newest_of_a_topic_win_and_other_topics_keep_theirs():
    async def check():
        outbox = Outbox(1000)
        outbox.put_message("b", "b1", 1)
        for number in range(5):
            outbox.put_message("a", f"a{number}", 2)
        outbox.put_message("b", "b2", 1)
        assert len(outbox) == 3
        assert await taken(outbox) == ["a3", "a4", "b2"]

    run(check())


def test_all_together_is_bounded_and_replies_survive():
    async def check():
        outbox = Outbox(100)
        outbox.put_message("a", "a" * 40, 10)
        outbox.put_reply("r" * 20)
        outbox.put_message("b", "b" * 40, 10)
        outbox.put_message("b", "c" * 39, 10)
        assert await taken(outbox) == ["r" * 20, "b" * 40, "c" * 39]

    run(check())


def test_one_message_larger_than_all_room_still_goes_out():
    async def check():
        outbox = Outbox(10)
        outbox.put_message("a", "x" * 30, 1)
        assert await taken(outbox) == ["x" * 30]
        outbox.put_reply("y" * 30)
        assert await taken(outbox) == ["y" * 30]

    run(check())


def test_a_client_that_takes_no_replies_is_found_out():
    async def check():
        outbox = Outbox(1000, max_replies=3)
        for _ in range(3):
            outbox.put_reply("r")
        with pytest.raises(OutboxFullError):
            outbox.put_reply("r")
        outbox = Outbox(100)
        outbox.put_reply("r" * 60)
        with pytest.raises(OutboxFullError):
            outbox.put_reply("r" * 60)

    run(check())


def test_get_waits_for_the_next_message():
    async def check():
        outbox = Outbox(1000)
        waiting = asyncio.ensure_future(outbox.get())
        await asyncio.sleep(0)
        outbox.put_message("a", "first", 1)
        assert await waiting == "first"

    run(check())


class Counter:
    """Counts how often a message is turned into JSON."""

    type_name = "std_msgs/Int32"

    def __init__(self):
        self.calls = 0

    def to_json(self, message):
        self.calls += 1
        return {"data": message.data}


def test_a_message_is_encoded_once_for_all_spellings():
    codec = Counter()
    message = TopicMessage(codec, Int32(5))
    assert message.encoded("/x") == '{"op":"publish","topic":"/x","msg":{"data":5}}'
    assert message.encoded("x") == '{"op":"publish","topic":"x","msg":{"data":5}}'
    assert message.encoded("/x") is message.encoded("/x")
    assert codec.calls == 1


class Sent(list):
    """What was sent, and when."""

    def __init__(self):
        self.times = []

    def __call__(self, topic, text, depth):
        self.times.append(asyncio.get_running_loop().time())
        self.append((text.rpartition(":")[2].rstrip("}"), depth))


def number(value):
    return TopicMessage(codec_of(Int32), Int32(value))


def test_throttle_lets_the_newest_through_when_it_is_due():
    async def check():
        sent = Sent()
        subscription = ClientSubscription("/x", None, "/x", subscribers=None, send=sent)
        subscription.add("one", Wish(throttle=0.05, depth=4, compression="none"), limit=10)
        for value in range(5):
            subscription.deliver(number(value))
        await wait_until_async(lambda: sent == [("4", 4)])
        for value in range(5, 8):
            subscription.deliver(number(value))
        await wait_until_async(lambda: sent == [("4", 4), ("7", 4)])
        assert sent.times[1] - sent.times[0] > 0.045
        await asyncio.sleep(0.08)
        assert len(sent) == 2
        subscription.deliver(number(9))
        await wait_until_async(lambda: sent[-1] == ("9", 4))

    run(check())


def test_the_most_demanding_wish_holds_until_it_is_withdrawn():
    async def check():
        sent = Sent()
        subscription = ClientSubscription("/x", None, "/x", subscribers=None, send=sent)
        subscription.add("slow", Wish(throttle=60.0, depth=9, compression="none"), limit=10)
        subscription.add("fast", Wish(throttle=0.0, depth=3, compression="none"), limit=10)
        for value in range(3):
            subscription.deliver(number(value))
        assert sent == [("0", 3), ("1", 3), ("2", 3)]
        subscription.remove("fast")
        assert subscription.wanted
        subscription.deliver(number(3))
        subscription.deliver(number(4))
        await asyncio.sleep(0.05)
        assert len(sent) == 3  # the last one went just now
        subscription.remove("slow")
        assert not subscription.wanted
        subscription.close()
        subscription.deliver(number(5))
        assert len(sent) == 3

    run(check())
