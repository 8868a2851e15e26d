from __future__ import annotations

from dataclasses import dataclass, field
from typing import Dict, Tuple

import pytest

from telex_control.node_handle import LocalNodeHandle, ParameterError
from telex_control.params import ConfigError, read_config, require


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
        ({"name": 3}, "/n/name is 3; a str is needed"),
        ({"name": "x", "colour": 1}, "/n/colour is unknown; known are count"),
        ({"name": "x", "count": 1.5}, "/n/count is 1.5; a int is needed"),
        ({"name": "x", "count": True}, "/n/count is True"),
        ({"name": "x", "on": 1}, "/n/on is 1"),
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


def test_node_handle_parameters():
    node = LocalNodeHandle({"robot": {"c": {"rate": 5, "name": "x", "on": True}}}, "/robot")
    child = node.child("c")
    assert child.param("rate", float) == 5.0
    assert child.param("name", str) == "x"
    assert child.param("missing", str, "default") == "default"
    with pytest.raises(ParameterError, match="/robot/c/missing is missing"):
        child.param("missing", str)
    with pytest.raises(ParameterError, match="/robot/c/on is True; a float is needed"):
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
