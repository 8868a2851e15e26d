"""The figures of the line are the same for bridge, message and exercises."""

from __future__ import annotations

import dataclasses

from telex_msgs.msg import LinkState

from telex_teleop.web.line.fields import LineFields
from telex_training.exercises.model import LINK_FIELDS


def test_bridge_message_and_exercises_know_the_same_figures():
    names = tuple(field.name for field in dataclasses.fields(LineFields))
    assert names == LINK_FIELDS
    assert set(names) <= set(LinkState.__slots__)
    assert LineFields.of(LinkState()).is_perfect
