"""What a server that was started again has in common with the one that crashed, and who is told."""

from __future__ import annotations

import pytest
from web_fakes import FakeRos, becomes, on_loop, served

from telex_teleop.web.bridge.app import Rosbridge
from telex_teleop.web.config import RosbridgeConfig
from telex_teleop.web.serving import bind, bind_again, url_of
from telex_teleop.web.tokens import tokens_of

PUBLIC = RosbridgeConfig(address="0.0.0.0")


def port_of(listener):
    return listener.getsockname()[1]


def test_a_server_comes_back_at_its_port():
    with bind("127.0.0.1", 0, "/v") as first:
        url, port = url_of("http", first), port_of(first)
    with bind_again("127.0.0.1", 0, "/v", url) as second:
        assert port_of(second) == port


def test_it_takes_another_one_if_somebody_has_it_now():
    with bind("127.0.0.1", 0, "/v") as taken, bind_again(
        "127.0.0.1", 0, "/v", url_of("http", taken)
    ) as second:
        assert port_of(second) != port_of(taken)


def test_a_port_that_is_asked_for_is_taken_whatever_was_before():
    with bind("127.0.0.1", 0, "/v") as probe:
        wanted = port_of(probe)
    with bind_again("127.0.0.1", wanted, "/v", "http://127.0.0.1:1") as second:
        assert port_of(second) == wanted


@pytest.mark.parametrize("left", [None, 3, "", "nonsense", "http://host", "http://host:99999999"])
def test_an_address_that_makes_no_sense_is_passed_over(left):
    with bind_again("127.0.0.1", 0, "/v", left) as listener:
        assert port_of(listener) > 0


def test_made_up_tokens_stay_the_same():
    first = tokens_of(PUBLIC)
    assert tokens_of(PUBLIC, first.made_up) == first
    assert tokens_of(PUBLIC) != first


def test_made_up_tokens_that_a_crash_has_left_among_the_parameters_are_not_given():
    first = tokens_of(PUBLIC)
    left = RosbridgeConfig(address="0.0.0.0", token=first.client, instructor_token=first.instructor)
    # Else nobody would be told, and they would stay there after an end in order.
    assert tokens_of(left, first.made_up) == first


def test_given_tokens_win_and_are_not_made_up():
    given = RosbridgeConfig(address="0.0.0.0", token="a", instructor_token="b")
    assert tokens_of(given).made_up == {}
    earlier = {"token": "old", "instructor_token": "older"}
    assert (tokens_of(given, earlier).client, tokens_of(given, earlier).instructor) == ("a", "b")
    partly = RosbridgeConfig(address="0.0.0.0", token="a")
    assert tokens_of(partly, earlier).instructor == "older"
    assert tokens_of(partly, earlier).made_up == {"instructor_token": "older"}


@pytest.mark.parametrize("earlier", [{}, {"token": ""}, {"token": 3, "instructor_token": None}])
def test_what_makes_no_token_is_made_up_anew(earlier):
    tokens = tokens_of(PUBLIC, earlier)
    assert len(tokens.client) == len(tokens.instructor) == 16


def bridge(ros):
    return served(Rosbridge(RosbridgeConfig(), ros, lambda sentence: None).make_app(), "ws")


@on_loop
async def test_a_node_that_has_crashed_is_named_until_it_answers():
    ros = FakeRos()
    async with bridge(ros):
        await becomes(lambda: ros.missing == [[]])
        ros.crashed.add("/telex/arm_teleop")
        await becomes(lambda: ros.missing[-1] == ["/telex/arm_teleop"])
        ros.crashed.clear()
        await becomes(lambda: ros.missing[-1] == [])
    # Nothing is repeated that has not changed.
    assert len(ros.missing) == 3


@on_loop
async def test_nodes_elsewhere_are_none_of_its_business():
    ros = FakeRos()
    ros.nodes = lambda: ["/other/arm_teleop", "/telex2/cameras", "/telex/cameras"]
    ros.crashed.update(ros.nodes())
    async with bridge(ros):
        await becomes(lambda: ros.missing == [["/telex/cameras"]])
