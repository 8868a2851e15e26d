"""Commands and questions of an operator's port."""

from __future__ import annotations

import math

import numpy as np
import pytest
from flat_floor import FlatFloor

from telex_training.operators.port import Drive, Jog, NotManagedError, ToolPose, ToolTwist


@pytest.mark.parametrize("wrong", [math.nan, math.inf, -math.inf])
def test_a_command_has_finite_numbers_only(wrong: float) -> None:
    with pytest.raises(ValueError, match=r"linear of Drive is (nan|-?inf)"):
        Drive(wrong)
    with pytest.raises(ValueError, match="rates of Jog"):
        Jog("arm_teleop", {"elbow_joint": wrong})
    with pytest.raises(ValueError, match="angular of ToolTwist"):
        ToolTwist(angular=(0.0, wrong, 0.0))
    target = np.eye(4)
    target[0, 3] = wrong
    with pytest.raises(ValueError, match="target of ToolPose"):
        ToolPose(target)


def test_a_question_is_answered_where_somebody_asks() -> None:
    port, given = FlatFloor(), []  # type: FlatFloor, List[Tuple[str, str]]
    with pytest.raises(NotManagedError, match="'label' cannot be answered: nobody asks"):
        port.answer("label", "up")
    port.on_answer = lambda question, answer: given.append((question, answer))
    port.answer("label", "up")
    assert given == [("label", "up")]
