from __future__ import annotations

from dataclasses import dataclass, field
from typing import Dict, Optional, Tuple

import pytest

from telex_control.common.params import (
    ConfigError,
    read_config,
    read_struct,
    require,
    require_choice,
    require_names,
    require_range,
    require_text,
    required,
    shown,
)
from telex_control.ros.local_node_handle import LocalNodeHandle


@dataclass(frozen=True)
class Inner:
    gain: float = 1.0

    def __post_init__(self):
        require(self.gain > 0.0, f"gain is {self.gain}; it must be above 0")


@dataclass(frozen=True)
class Outer:
    name: str
    count: int = 3
    on: bool = False
    place: Tuple[float, float] = (0.0, 0.0)
    names: Tuple[str, ...] = ()
    inner: Inner = field(default_factory=Inner)
    many: Dict[str, Inner] = field(default_factory=dict)


def test_values_and_defaults():
    config = read_config(
        Outer,
        {"name": "x", "place": [1, 2.5], "names": ["a"], "inner": {"gain": 2}, "many": {"j": {}}},
        "~",
    )
    assert config == Outer(
        "x", place=(1.0, 2.5), names=("a",), inner=Inner(2.0), many={"j": Inner()}
    )


@pytest.mark.parametrize(
    ("params", "named"),
    [
        ({}, "/n/name is missing"),
        ({"name": 3}, "/n/name is 3; a string is needed"),
        ({"name": "x", "colour": 1}, "/n/colour is unknown; known are count"),
        ({"name": "x", "count": 1.5}, "/n/count is 1.5; an integer is needed"),
        ({"name": "x", "count": True}, "/n/count is True"),
        ({"name": "x", "on": 1}, "/n/on is 1; true or false is needed"),
        ({"name": "x", "place": [1.0]}, "/n/place has 1 elements; 2 are needed"),
        ({"name": "x", "place": 1.0}, "a list is needed"),
        ({"name": "x", "inner": {"gain": -1.0}}, "/n/inner: gain is -1.0"),
        ({"name": "x", "inner": {"gain": float("nan")}}, "/n/inner/gain is nan; it must be finite"),
        ({"name": "x", "many": {"j": {"gain": "big"}}}, "/n/many/j/gain is 'big'"),
        ({"name": "x", "many": []}, "a struct is needed"),
        ([], "a struct is needed"),
    ],
)
def test_mistakes_are_named(params, named):
    with pytest.raises(ConfigError) as caught:
        read_config(Outer, params, "/n")
    assert named in str(caught.value)


@dataclass(frozen=True)
class Checked:
    port: int = 80
    rate: float = 1.0
    limit: Optional[float] = None
    mode: str = "slow"
    title: str = "x"
    joints: Tuple[str, ...] = ("a",)

    def __post_init__(self):
        require_range(self, "port", 0, 65535)
        require_range(self, "rate", above=0.0, maximum=0.3 if self.mode == "slow" else 1e9)
        require_range(self, "limit", 0.5)
        require_choice(self, "mode", ("slow", "fast"))
        require_text(self, "title")
        require_names(self, "joints")


SLOW = {"rate": 0.3}


def test_what_the_checks_accept():
    config = read_config(Checked, {**SLOW, "port": 65535, "limit": 0.5}, "/n")
    assert (config.port, config.rate, config.limit) == (65535, 0.3, 0.5)
    assert read_config(Checked, {**SLOW, "limit": None}, "/n").limit is None
    assert read_config(Checked, SLOW, "/n").limit is None


@pytest.mark.parametrize(
    ("params", "named"),
    [
        ({"port": 65536}, "/n: port is 65536; it must be at least 0 and at most 65535"),
        ({"port": -1}, "port is -1; it must be at least 0"),
        ({"rate": 0}, "rate is 0.0; it must be above 0 and at most 0.3"),
        ({"rate": 0.31}, "rate is 0.31"),
        ({"rate": float("inf"), "mode": "fast"}, "rate is inf; it must be finite"),
        ({"limit": 0.4}, "limit is 0.4; it must be at least 0.5"),
        ({"limit": "much"}, "/n/limit is 'much'; a number is needed"),
        ({"limit": float("nan")}, "/n/limit is nan; it must be finite"),
        ({"mode": "still"}, "mode is 'still'; slow, fast are possible"),
        ({"title": ""}, "title is ''; it must not be empty"),
        ({"joints": []}, "joints is []; a list of distinct names is needed"),
        ({"joints": ["a", "a"]}, "joints is ['a', 'a']; a list of distinct names"),
        ({"joints": [""]}, "joints is ['']; a list of distinct names"),
        ({"joints": ["a", 1]}, "/n/joints[1] is 1; a string is needed"),
        ({"joints": None}, "/n/joints is None; a list is needed"),
    ],
)
def test_checks_name_value_and_remedy(params, named):
    with pytest.raises(ConfigError) as caught:
        read_config(Checked, {**SLOW, **params}, "/n")
    assert named in str(caught.value)


@pytest.mark.parametrize("value", [float("nan"), float("inf"), 0.0])
def test_ranges_hold_also_for_what_is_made_in_code(value):
    with pytest.raises(ConfigError, match="rate is"):
        Checked(rate=value, mode="fast" if value else "slow")


def test_keys_are_strings_also_where_yaml_sees_a_number():
    assert set(read_config(Outer, {"name": "x", "many": {1: {}, "a": {}}}, "/n").many) == {"1", "a"}


@dataclass(frozen=True)
class Derived(Checked):
    place: str = field(default_factory=required)


def test_derived_classes_can_require_more():
    assert read_config(Derived, {**SLOW, "place": "here"}, "/n").place == "here"
    with pytest.raises(ConfigError, match="/n/place is missing"):
        read_config(Derived, SLOW, "/n")
    with pytest.raises(ConfigError, match="missing"):
        Derived(rate=0.1)


def test_node_handle_parameters():
    node = LocalNodeHandle({"robot": {"c": {"rate": 5, "name": "x", "on": True}}}, "/robot")
    child = node.child("c")
    assert child.param("rate", float) == 5.0
    assert child.param("name", str) == "x"
    assert child.param("missing", str, "default") == "default"
    with pytest.raises(ConfigError, match="/robot/c/missing is missing"):
        child.param("missing", str)
    with pytest.raises(ConfigError, match="/robot/c/on is True; a number is needed"):
        child.param("on", float)


def test_local_topics_reach_their_subscribers_until_shutdown():
    node = LocalNodeHandle()
    received = []
    other = node.child("c")
    publisher = node.advertise("c/x", object)
    assert not publisher.has_subscribers()
    other.subscribe("x", object, received.append)
    publisher.publish(1)
    other.shutdown()
    publisher.publish(2)
    assert received == [1]


@pytest.mark.parametrize(
    ("values", "name", "said"),
    [
        ({"name": 3}, "", "name is 3; a string is needed"),
        ({"name": "x", "inner": {"gain": -1.0}}, "", "inner: gain is -1.0; it must be above 0"),
        ({"name": "x", "inner": {"gain": 10**400}}, "box", "box/inner/gain is 1000"),
        ({"name": "x", "colour": 1}, "box", "box/colour is unknown; known are "),
        ([1], "", "it is [1]; a struct is needed"),
        ({"name": list(range(1000))}, "", "name is [0, 1, 2"),
    ],
)
def test_values_of_a_file_are_named_without_a_parameters_prefix(values, name, said):
    with pytest.raises(ConfigError) as caught:
        read_struct(Outer, values, name)
    assert str(caught.value).startswith(said)
    assert len(str(caught.value)) < 150


@pytest.mark.parametrize(
    ("value", "text"),
    [
        ([1, {"a": None}, "b"], "[1, {'a': None}, 'b']"),
        ("x" * 1000, "'" + "x" * 76 + "..."),
        ([[[["deep"]]]], "[[[[...]]]]"),
        (list(range(10**6)), str(list(range(20)))[:-1] + ", ...]"),
    ],
    ids=("short", "long", "deep", "wide"),
)
def test_values_are_shown_as_far_as_a_message_has_room(value, text):
    assert shown(value) == text


def test_a_struct_checks_itself_in_a_file_too():
    with pytest.raises(ConfigError, match="^gain is -1.0; it must be above 0$"):
        read_struct(Inner, {"gain": -1.0})
