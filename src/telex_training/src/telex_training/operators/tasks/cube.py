"""A small cube out of one box into another, by the pictures of gripper and turret camera alone."""

from __future__ import annotations

import contextlib
import math
from typing import Any, Dict, Tuple

import cv2
import numpy as np

from telex_control.common.geometry.matrices import inverse

from .. import driving
from ..eye import Eye
from ..handling import Hand, aimed
from ..port import NotManagedError
from ..station import Station
from ..vision import Blob, SeenPicture, VividColor, cube_place, find, project, ray
from .task import OperatorTask, Verdict

# What the operator has been told: two boxes on a low table, and a green cube in the red one.
EDGE = 0.05  # m, of the cube
TABLE = 0.25  # m
BOX = (0.32, 0.24, 0.10)  # m
WALL = 0.008  # m
RED, GREEN, BLUE = VividColor("red", 2.0), VividColor("green", 122.0), VividColor("blue", 230.0)

_AXLE = 0.11  # m, of base_link over the floor
_BOX_MIDDLE = TABLE + 0.5 * BOX[2] - _AXLE  # m, over base_link
_CUBE_MIDDLE = TABLE + WALL + 0.5 * EDGE - _AXLE

_AHEAD, _SCATTER = 1.55, (0.06, 0.06, 0.10)  # m, m, m, rad
_APART = 0.19  # m, of a box from the table's middle
_BOX_SCATTER = (0.02, 0.01, 0.15)
_CUBE_SCATTER = (0.06, 0.03)  # m, in its box
_REACH = 0.92  # m, from base_link to the boxes
_DOWN = 0.5 * math.pi
OPENING = 0.24  # rad; 9 cm, and the hand clears the walls
_SECOND_LOOK = (-0.07, 0.24, 1.40)  # m behind the cube, m above it, rad down
GRASP_ABOVE = 0.034  # m, for the fingertips reach 5 cm beyond the tool, and stay off the floor
_OVER, _RELEASE = 0.20, 0.05  # m, over the middle of the boxes
_SURE = 0.7
"""Overlap of the outlines of what is seen and of a cube, at least."""
_IN_GRIP = 45.0  # pixels
_TRIES = 2


class CubeToBox(OperatorTask):
    """Cube of 5 cm, found by its colour, from a red box into a blue one."""

    measure = "cube from the middle of the blue box (m)"
    subject = "cube"
    view = ("follow", -0.7, 0.5, 2.6, (0.7, 0.0, 0.2))

    def lay_out(self, rng: np.random.Generator) -> Dict[str, Dict[str, Any]]:
        """Put table, boxes and cube before the robot; see `OperatorTask.lay_out`."""
        ahead, aside, turn = (
            float(middle + rng.uniform(-each, each))
            for middle, each in zip((_AHEAD, 0.0, 0.0), _SCATTER)
        )

        def on_table(x: float, y: float, z: float, yaw: float) -> Dict[str, Any]:
            c, s = math.cos(turn), math.sin(turn)
            place = (ahead + c * x - s * y, aside + s * x + c * y, z)
            return {"position": [round(each, 4) for each in place], "yaw": round(turn + yaw, 4)}

        def scattered(limits: Tuple[float, ...]) -> Tuple[float, ...]:
            return tuple(float(rng.uniform(-each, each)) for each in limits)

        things: Dict[str, Dict[str, Any]] = {
            "table": {
                "type": "table",
                **on_table(0.0, 0.0, 0.0, _DOWN),
                "length": 0.9,
                "width": 0.5,
                "height": TABLE,
            }
        }
        colors = {"red_box": [0.75, 0.08, 0.06], "blue_box": [0.06, 0.16, 0.75]}
        places = {}
        for side, name in ((1.0, "red_box"), (-1.0, "blue_box")):
            dx, dy, yaw = scattered(_BOX_SCATTER)
            places[name] = (dx, side * _APART + dy, yaw)
            things[name] = {
                "type": "bin",
                **on_table(dx, side * _APART + dy, TABLE, _DOWN + yaw),
                "size": list(BOX),
                "wall": WALL,
                "color": colors[name],
            }
        dx, dy, yaw = places["red_box"]
        along, across = scattered(_CUBE_SCATTER)
        x = dx - along * math.sin(yaw) - across * math.cos(yaw)
        y = dy + along * math.cos(yaw) - across * math.sin(yaw)
        things["cube"] = {
            "type": "cube",
            **on_table(x, y, TABLE + WALL + 0.002, float(rng.uniform(-math.pi, math.pi))),
            "edge": EDGE,
            "color": [0.08, 0.70, 0.12],
        }
        return things

    def begin(self, station: Station) -> None:
        """See `OperatorTask.begin`."""

    def act(self, hand: Hand) -> None:
        """Bring it over; see `OperatorTask.act`. The ground truth is not looked at."""
        station = hand.station
        with contextlib.closing(Eye(station, "turret")) as turret:
            self._go_there(hand, turret)
        with contextlib.closing(Eye(station, "gripper")) as gripper:
            hand.to_named_pose("ready")
            hand.open(OPENING)
            for turn in range(_TRIES):
                if self._take(hand, gripper):
                    break
                if turn == _TRIES - 1:
                    raise NotManagedError(f"the cube is not in the gripper; {station.where()}")
                hand.open(OPENING)
            self._put(hand, gripper)

    def _go_there(self, hand: Hand, turret: Eye) -> None:
        """Drive before the boxes, square to them, as the turret camera shows them."""
        station = hand.station
        view = turret.look()
        red, blue = (self._on_level(view, color, _BOX_MIDDLE) for color in (RED, BLUE))
        middle, across = 0.5 * (red + blue), red - blue
        ahead = np.array([across[1], -across[0], 0.0]) / np.hypot(across[0], across[1])
        base = station.base()
        stand = base @ np.append(middle - _REACH * ahead, 1.0)
        far = base @ np.append(middle - (_REACH + 0.25) * ahead, 1.0)
        direction = base[:3, :3] @ ahead
        station.hold_preset("approach")
        heading = math.atan2(direction[1], direction[0])
        driving.drive_to(station, (far[0], far[1]))
        driving.turn_to(station, heading)
        driving.run_to(station, (stand[0], stand[1]), 0.25, heading=heading)
        station.stop()
        station.wait(0.4)
        station.hold_preset("")

    def _on_level(self, view: SeenPicture, color: VividColor, height: float) -> np.ndarray:
        """Place of a thing (m, base_link) whose middle is known to be at a height."""
        return ray(view, self._seen(view, color).center).at_height(height)

    def _seen(self, view: SeenPicture, color: VividColor) -> Blob:
        blob = find(view.image, color)
        if blob is None:
            raise NotManagedError(f"nothing {color.name} in the picture")
        return blob

    def _take(self, hand: Hand, gripper: Eye) -> bool:
        """Grasp the cube and lift it; tell whether the picture shows it between the fingers."""
        station = hand.station
        hand.to(aimed(_REACH - 0.07, 0.0, 0.55, 0.0, 1.3), tolerance=0.02)
        station.wait(0.3)
        first = gripper.look()
        self._blue = self._on_level(first, BLUE, _BOX_MIDDLE)
        guess = self._on_level(first, GREEN, _CUBE_MIDDLE)
        back, up, down = _SECOND_LOOK
        hand.to(aimed(guess[0] + back, guess[1], guess[2] + up, 0.0, down), tolerance=0.01)
        station.wait(0.4)
        second = gripper.look()
        near = self._seen(second, GREEN)
        center, yaw, overlap = cube_place(second, near, _CUBE_MIDDLE, EDGE)
        if overlap < _SURE:
            raise NotManagedError(
                f"what is green has no cube's outline (overlap {overlap:.2f}); {station.where()}"
            )
        x, y, z = center[0], center[1], center[2] + GRASP_ABOVE
        hand.to(aimed(x, y, z + 0.12, yaw, _DOWN), tolerance=0.008)
        hand.to(aimed(x, y, z, yaw, _DOWN), tolerance=0.008)
        felt = hand.close_on_something()
        hand.to(aimed(x, y, z + _OVER, yaw, _DOWN), tolerance=0.01)
        if not felt:
            return False
        station.wait(0.3)
        # As the paper's operators: lift, and look whether it comes along.
        lifted = gripper.look()
        blob = find(lifted.image, GREEN)
        if blob is None:
            return False
        expected = project(lifted, (hand.tool() @ (GRASP_ABOVE, 0.0, 0.0, 1.0))[None, :3])[0]
        return bool(np.linalg.norm(expected - blob.center) < _IN_GRIP)

    def _put(self, hand: Hand, gripper: Eye) -> None:
        """Put the cube into the blue box, and look whether it lies there."""
        station = hand.station
        x, y, z = self._blue
        hand.to(aimed(x, y, z + _OVER, 0.0, _DOWN), tolerance=0.01)
        hand.to(aimed(x, y, z + _RELEASE, 0.0, _DOWN), tolerance=0.008)
        hand.open(OPENING)
        hand.to(aimed(x - 0.1, y, z + 0.3, 0.0, 1.35), tolerance=0.02)
        station.wait(0.4)
        view = gripper.look()
        cube, box = self._seen(view, GREEN), self._seen(view, BLUE)
        outline = box.hull.astype(np.float32).reshape(-1, 1, 2)
        if cv2.pointPolygonTest(outline, cube.center, False) < 0:
            raise NotManagedError(f"the cube is not seen in the blue box; {station.where()}")

    def judge(self, station: Station) -> Verdict:
        """See `OperatorTask.judge`: the cube lies on the floor of the blue box, which stands."""
        box, cube = station.object_pose("blue_box"), station.object_pose("cube")
        x, y, z = (inverse(box) @ (cube @ (0.0, 0.0, 0.5 * EDGE, 1.0)))[:3]
        inside = abs(x) < 0.5 * BOX[0] and abs(y) < 0.5 * BOX[1] and 0.0 < z < BOX[2]
        stands = box[2, 2] > 0.99
        off = float(math.hypot(x, y))
        where = "in the blue box" if inside else "not in the blue box"
        return Verdict(
            bool(inside and stands), off, f"{where}, {100.0 * off:.1f} cm off its middle"
        )
