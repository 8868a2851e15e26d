"""Commands of an operator's port."""

from __future__ import annotations

import math

import numpy as np
import pytest

from telex_training.operators.port import Drive, Jog, ToolPose, ToolTwist


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
