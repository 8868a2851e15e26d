"""Filmstrips of what the instructor's camera shows."""

from __future__ import annotations

from pathlib import Path
from typing import Any, List, Sequence, Tuple

import cv2
import numpy as np
from sensor_msgs.msg import CompressedImage
from telex_msgs.msg import OverviewView

from telex_control.ros.node_handle import NodeHandle
from telex_experiments.rigs.contact_sheet import captioned, sheet
from telex_training.operators.eye import PATIENCE
from telex_training.operators.port import NotManagedError
from telex_training.operators.station import Station

WIDTH = 420  # pixels, of a picture in the strip
QUALITY = 82  # of the JPEG


class Film:
    """Keeps pictures of ``cameras/overview`` at intervals of sim time; close it when done.

    Parameters
    ----------
    interval : float
        At least so much between two pictures (s).
    """

    def __init__(self, station: Station, node: NodeHandle, interval: float = 0.4) -> None:
        self._station = station
        self._interval = interval
        self._shots: List[Tuple[float, bytes]] = []
        self._node = node.child("cameras/overview")
        self._view = self._node.advertise("view", OverviewView)
        self._node.subscribe("image_raw/compressed", CompressedImage, self._on_picture)

    def _on_picture(self, message: Any) -> None:
        stamp = message.header.stamp.to_sec()
        if not self._shots or stamp >= self._shots[-1][0] + self._interval:
            self._shots.append((stamp, bytes(message.data)))

    def look_from(
        self,
        mode: str,
        azimuth: float,
        elevation: float,
        distance: float,
        center: Sequence[float] = (0.0, 0.0, 0.2),
    ) -> None:
        """Send the camera somewhere; see telex_msgs/OverviewView."""
        view = OverviewView(mode=mode, azimuth=azimuth, elevation=elevation, distance=distance)
        view.center.x, view.center.y, view.center.z = center
        # Its node may not listen yet: nobody asks for the first picture but this film.
        self._station.until(
            lambda: self._view.has_subscribers(), 10.0, "somebody who moves the overview camera"
        )
        self._view.publish(view)

    def cut(self) -> None:
        """Begin anew."""
        self._shots = []

    def wait(self) -> None:
        """Wait for the first picture: a renderer that has yet to start misses the beginning.

        Raises
        ------
        NotManagedError
            None comes.
        """
        self._station.until(lambda: bool(self._shots), PATIENCE, "a picture of camera overview")

    def strip(self, path: Path, pictures: int, columns: int) -> None:
        """Write so many pictures, evenly chosen among those that came, as a JPEG.

        Where the renderer had time for fewer, down to half of them, they are all there is.

        Raises
        ------
        NotManagedError
            There are fewer than half.
        """
        shots = list(self._shots)
        if 2 * len(shots) < pictures:
            raise NotManagedError(
                f"cameras/overview gave {len(shots)} pictures; {pictures} are wanted, half needed"
            )
        count = min(pictures, len(shots))
        chosen = [shots[round(index)] for index in np.linspace(0, len(shots) - 1, count)]
        cells = [_cell(data, stamp - shots[0][0]) for stamp, data in chosen]
        cv2.imwrite(str(path), sheet(cells, columns), [cv2.IMWRITE_JPEG_QUALITY, QUALITY])

    def close(self) -> None:
        """Look away."""
        self._node.shutdown()


def _cell(data: bytes, seconds: float) -> np.ndarray:
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    height = round(image.shape[0] * WIDTH / image.shape[1])
    return captioned(
        cv2.resize(image, (WIDTH, height), interpolation=cv2.INTER_AREA), f"{seconds:.1f} s"
    )
