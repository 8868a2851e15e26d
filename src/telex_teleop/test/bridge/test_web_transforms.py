"""Which transforms a web client is told of, and when."""

from __future__ import annotations

import math

import actionlib
import genpy
import pytest
from actionlib_msgs.msg import GoalID
from geometry_msgs.msg import Transform
from tf2_web_republisher.msg import TFSubscriptionGoal

from telex_teleop.web.transforms.transforms_node import Server
from telex_teleop.web.transforms.watch import Audience, TransformWatch, WishError, angle


def transform(x=0.0, yaw=0.0):
    made = Transform()
    made.translation.x = x
    made.rotation.z, made.rotation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return made


def goal(**fields):
    wishes = {"source_frames": ["/arm"], "target_frame": "/odom", "rate": 10.0}
    return TFSubscriptionGoal(**{**wishes, **fields})


@pytest.mark.parametrize("turn", [0.0, 1e-4, 0.02, -0.02, 3.0, -3.1])
def test_angles_between_transforms(turn):
    for yaw in (0.0, 1.0, -2.5):
        first, second = transform(yaw=yaw), transform(yaw=yaw + turn)
        assert angle(first, second) == pytest.approx(abs(turn), abs=1e-9)
        second.rotation.z, second.rotation.w = -second.rotation.z, -second.rotation.w  # the same
        assert angle(first, second) == pytest.approx(abs(turn), abs=1e-9)


def test_a_transform_is_told_when_it_has_changed_by_enough():
    watch = TransformWatch(
        goal(source_frames=["/arm", "lost"], angular_thres=0.1, trans_thres=0.01)
    )
    now = {"arm": transform()}

    def news():
        return watch.news(lambda target, source: now.get(source), 5)

    (first,) = news()
    assert (first.header.frame_id, first.child_frame_id, first.header.stamp) == ("odom", "arm", 5)
    for x, yaw, told in (
        (0.009, 0.0, False),
        (0.011, 0.0, True),
        (0.011, 0.09, False),
        (0.015, 0.15, True),
        (0.006, 0.06, False),
        (-0.006, 0.1, True),
    ):
        now["arm"] = transform(x, yaw)
        assert bool(news()) is told, (x, yaw)
    now["lost"] = transform()
    assert [each.child_frame_id for each in news()] == ["lost"]


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ({"rate": 0.0}, "rate is 0; it must be from 0.01 to 100"),
        ({"rate": math.nan}, "rate is nan; it must be"),
        ({"trans_thres": -1.0}, "trans_thres is -1; it must be from 0 to inf"),
        ({"angular_thres": math.nan}, "angular_thres is nan"),
        ({"source_frames": []}, "source_frames has 0 names; it must have 1 to 200"),
        ({"source_frames": ["a"] * 201}, "source_frames has 201 names"),
        ({"source_frames": ["/"]}, "the name of a frame is empty"),
        ({"target_frame": ""}, "the name of a frame is empty"),
    ],
)
def test_wishes_that_cannot_be_met_say_why(fields, said):
    with pytest.raises(WishError) as error:
        TransformWatch(goal(**fields))
    assert str(error.value).startswith(said)


def test_an_audience_may_be_away_for_a_while():
    now, listeners = [100.0], [0]
    audience = Audience(lambda: listeners[0], 10.0, lambda: now[0])
    for moment, count, there in (
        (109.0, 0, True),
        (110.0, 0, False),
        (111.0, 2, True),
        (120.0, 0, True),
        (121.5, 0, False),
    ):
        now[0], listeners[0] = moment, count
        assert audience.is_there() is there, moment


def test_a_cancel_ends_one_goal_at_most(monkeypatch):
    obeyed = []
    monkeypatch.setattr(
        actionlib.ActionServer,
        "internal_cancel_callback",
        lambda _, goal_id: obeyed.append(goal_id),
    )
    server = Server.__new__(Server)
    for stamp in (0, 2**31):
        for goal_id in ("", "mine"):
            server.internal_cancel_callback(GoalID(genpy.Time(stamp), goal_id))
    assert obeyed == [GoalID(genpy.Time(), "mine")] * 2
