"""Nothing moves by a command that no operator could mean."""

from __future__ import annotations

import pytest
from geometry_msgs.msg import Twist
from std_msgs.msg import Float64

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("huge", [1e308, -1e308, 1e39, 1e17, -1e5])
def test_nothing_moves_by_such_commands(robot, huge):
    tested = robot()
    tested.run(0.5)
    before, place = tested.positions(), tested.simulation.body.base_pose()[0]
    told = 0
    for info, _ in tested.simulation.controllers.list_controllers():
        kind = info.type.rpartition("/")[2]
        if kind == "JointPositionController":
            tested.node.advertise(f"{info.name}/command", Float64).publish(Float64(huge))
            told += 1
        elif kind == "TrackedDriveController":
            for field, axis in (("linear", "x"), ("angular", "z")):
                message = Twist()
                setattr(getattr(message, field), axis, huge)
                tested.node.advertise(f"{info.name}/cmd_vel", Twist).publish(message)
                told += 1
    assert told > 15
    tested.run(0.5)
    assert tested.positions() == pytest.approx(before, abs=5e-3)
    assert tested.simulation.body.base_pose()[0] == pytest.approx(place, abs=2e-3)
