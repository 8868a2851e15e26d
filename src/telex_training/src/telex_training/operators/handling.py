"""Moving the tool in straight lines, and gripping."""

from __future__ import annotations

import math
from typing import Callable, Optional

import numpy as np

from telex_control.common.geometry.matrices import homogeneous, rotation_from_rpy, rotation_vector

from .port import NotManagedError
from .station import Station

TOOL = "tool_link"
GRIPPER_CAMERA = "gripper_camera_optical_frame"
GRIPPER = "gripper"
"""The joint of gripper_teleop that moves all fingers."""
OPEN = 0.5
"""Of a base joint (rad), with the fingers wide open."""
CLOSING_ON = 0.05
"""By which fingers move on once `Hand.open` lets go of their key (rad): for its dead man's time."""
_FINGERS = ("left_finger_base_joint", "right_finger_base_joint")

_CLOSE_RATE, _SQUEEZE_RATE = 0.16, 0.03  # rad/s
_CREEPING, _STANDING = 0.002, 0.5
"""Fingers that move by less (rad) in such a time (s) stand."""
_BEGINNING = 1.0  # s
_EMPTY = 0.01
"""Of a base joint (rad), with the pads on one another."""
_PATIENCE = 2.5
"""How long the tool may stay where it is before the key is pressed anew, and once more before it
is given up (s)."""
_PROGRESS = 0.002  # m, rad


def aimed(
    x: float, y: float, z: float, yaw: float = 0.0, pitch: float = 0.0, roll: float = 0.0
) -> np.ndarray:
    """Pose of a tool at a place (m) that looks along a heading, so far down, rolled so far (rad).

    Returns
    -------
    ndarray, shape (4, 4)
    """
    return homogeneous(rotation_from_rpy((roll, pitch, yaw)), (x, y, z))


class Hand:
    """Arm and gripper at a station."""

    def __init__(self, station: Station) -> None:
        self.station = station

    def tool(self) -> np.ndarray:
        """Measured pose of the tool in base_link, 4x4."""
        return self.station.place_of(TOOL)

    def tool_in_world(self) -> np.ndarray:
        """The same in the world."""
        return self.station.base() @ self.tool()

    # --- the arm ---------------------------------------------------------------------------------

    def to_named_pose(self, name: str, timeout: float = 30.0) -> None:
        """Move the arm to a named pose.

        Raises
        ------
        NotManagedError
            It does not come there.
        """
        station = self.station
        station.notices.pop("arm_teleop", None)
        station.hold_named_pose(name)
        self._until(
            lambda: f"in pose {name}" in station.notices.get("arm_teleop", ""),
            timeout,
            f"the arm in pose {name}",
        )
        station.release_arm()

    def to(
        self,
        target: np.ndarray,
        frame: str = "base_link",
        timeout: float = 25.0,
        tolerance: float = 0.004,
        enough: Optional[Callable[[], bool]] = None,
    ) -> None:
        """Lead the tool on a straight line to a pose.

        Parameters
        ----------
        target : ndarray, shape (4, 4)
        frame : str
            base_link or world.
        timeout : float
            s.
        tolerance : float
            Of the place (m); five times as many rad of the orientation.
        enough : callable, optional
            Ends the way earlier.

        Raises
        ------
        NotManagedError
            The tool does not come there: it does not move for 2.5 s, or the time is over.
        """
        self.station.hold_tool_pose(target, frame)
        here = self.tool if frame == "base_link" else self.tool_in_world

        def off() -> float:
            pose = here()
            place = float(np.linalg.norm(pose[:3, 3] - target[:3, 3]))
            turn = float(np.linalg.norm(rotation_vector(pose[:3, :3].T @ target[:3, :3])))
            return max(place, turn / 5.0)

        x, y, z = target[:3, 3]
        self._until(
            lambda: off() < tolerance or (enough is not None and enough()),
            timeout,
            f"the tool at {x:.2f} {y:.2f} {z:.2f} m of {frame}",
            off,
        )
        self.station.release_arm()

    def _until(
        self,
        reached: Callable[[], bool],
        timeout: float,
        what: str,
        off: Optional[Callable[[], float]] = None,
    ) -> None:
        """Wait, and give up early when what is left does not become less."""
        station = self.station
        best, since, pressed = math.inf, station.time, False

        def watch() -> None:
            nonlocal best, since, pressed
            if off is None:
                return
            if off() < best - _PROGRESS:
                best, since, pressed = off(), station.time, False
            elif station.time - since > 2.0 * _PATIENCE:
                self._give_up(f"{what}: {1000.0 * off():.0f} mm short, and no progress")
            elif station.time - since > _PATIENCE and not pressed:
                # As everybody does whose key seems dead.
                pressed = True
                station.press_anew("arm_teleop")

        try:
            station.until(reached, timeout, what, watch)
        except NotManagedError as error:
            self._give_up(str(error))

    def _give_up(self, reason: str) -> None:
        notice = self.station.notices.get("arm_teleop", "")
        self.station.release_arm()
        x, y, z = self.tool()[:3, 3]
        said = f"; arm_teleop says: {notice}" if notice else ""
        raise NotManagedError(f"{reason}; tool at {x:.3f} {y:.3f} {z:.3f} m of base_link{said}")

    # --- the gripper -----------------------------------------------------------------------------

    def opening(self) -> float:
        """Angle of the fingers' base joints (rad): 0 is closed."""
        return sum(self.station.measured(joint) for joint in _FINGERS) / len(_FINGERS)

    def force(self) -> float:
        """With which the pads hold something (N); 0 where they hold nothing."""
        return self.station.grip.force

    def open(self, angle: float = OPEN) -> None:
        """Open the gripper, or close it, to an angle of the fingers' base joints (rad).

        They come to stand `CLOSING_ON` beyond it.

        Raises
        ------
        NotManagedError
        """
        rate = math.copysign(_CLOSE_RATE, angle - self.opening())
        self.station.jog("gripper_teleop", **{GRIPPER: rate})
        self.station.until(
            lambda: (angle - self.opening()) * rate <= 0.01 * abs(rate),
            8.0,
            f"the gripper at {angle:.2f} rad",
        )
        self.station.release("gripper_teleop")

    def grip(self, force: float) -> None:
        """Close the gripper until it holds something with a force (N), as the display shows it.

        Raises
        ------
        NotManagedError
            The fingers meet without anything between them, or the force is not reached.
        """
        station = self.station

        def close() -> None:
            # Gently, once something is between the pads.
            rate = _SQUEEZE_RATE if self.force() > 0.3 * force else _CLOSE_RATE
            station.jog("gripper_teleop", **{GRIPPER: -rate})

        try:
            station.until(
                lambda: self.force() >= force or self.opening() < 0.01,
                8.0,
                f"a grip of {force:g} N",
                close,
            )
        except NotManagedError as error:
            raise NotManagedError(f"{error}; the grip is {self.force():.0f} N") from error
        finally:
            station.release("gripper_teleop")
        if self.force() < force:
            raise NotManagedError(f"the gripper closed on nothing; {station.where()}")

    def close_on_something(self) -> bool:
        """Close the gripper until its fingers stand, and press: told by the joints alone.

        Returns
        -------
        bool
            Whether something is between the fingers.

        Raises
        ------
        NotManagedError
            The fingers do not come to rest.
        """
        station = self.station
        # Fingers that have yet to begin stand, too.
        last, since = self.opening(), station.time + _BEGINNING

        def stands() -> bool:
            nonlocal last, since
            if abs(self.opening() - last) > _CREEPING:
                last, since = self.opening(), station.time
            return station.time - since > _STANDING

        station.jog("gripper_teleop", **{GRIPPER: -_CLOSE_RATE})
        try:
            station.until(stands, 8.0, "the fingers at rest")
        finally:
            station.release("gripper_teleop")
        return self.opening() >= _EMPTY

    def holds(self) -> str:
        """Name of what is between the pads, empty where nothing is."""
        return self.station.grip.object
