"""Validation of JointJog: one bad entry refuses the message, and the refusal names it."""

import math

import pytest

from telex_teleop.motion.joint_jog import InvalidCommand, parse_joint_jog

KNOWN = ("turret_joint", "elbow_joint")


def test_velocities():
    jog = parse_joint_jog(["elbow_joint"], [], [0.25], 0.0, KNOWN)
    assert jog.velocities == {"elbow_joint": 0.25}
    assert jog.displacements == {}
    assert jog.validity is None


def test_displacements():
    jog = parse_joint_jog(list(KNOWN), [0.1, -0.2], [], 0.0, KNOWN)
    assert jog.displacements == {"turret_joint": 0.1, "elbow_joint": -0.2}
    assert jog.velocities == {}


def test_duration_is_the_validity():
    assert parse_joint_jog(["elbow_joint"], [], [1], 0.1, KNOWN).validity == 0.1


@pytest.mark.parametrize(
    ("names", "displacements", "velocities", "duration", "says"),
    [
        ([], [], [], 0.0, "joint_names is empty"),
        (["knee_joint"], [], [1.0], 0.0, "unknown 'knee_joint'; this node moves turret_joint"),
        (["elbow_joint"] * 2, [], [1.0, 1.0], 0.0, "elbow_joint stands there twice"),
        (["elbow_joint"] * 5000, [], [1.0] * 5000, 0.0, "has 5000 entries; this node moves 2"),
        (["elbow_joint"], [1.0], [1.0], 0.0, "both given"),
        (["elbow_joint"], [], [], 0.0, "both empty"),
        (["elbow_joint"], [], [1.0, 2.0], 0.0, "velocities has 2 entries for 1"),
        (list(KNOWN), [1.0], [], 0.0, "displacements has 1 entries for 2"),
        (list(KNOWN), [], [0.1, math.nan], 0.0, "velocities of elbow_joint is nan"),
        (list(KNOWN), [math.inf, 0.1], [], 0.0, "displacements of turret_joint is inf"),
        (["elbow_joint"], [], [1.0], -1.0, "duration is -1.0"),
        (["elbow_joint"], [], [1.0], math.nan, "duration is nan"),
        (["elbow_joint"], [], [1.0], 1e308, "duration is 1e.308"),
        (list(KNOWN), [], [0.1, -1e39], 0.0, "velocities of elbow_joint is -1e.39"),
        (["elbow_joint"], [1e17], [], 0.0, "displacements of elbow_joint is 1e.17"),
    ],
)
def test_bad_messages_are_refused_by_name(names, displacements, velocities, duration, says):
    with pytest.raises(InvalidCommand, match=says):
        parse_joint_jog(names, displacements, velocities, duration, KNOWN)
