"""A camera's pictures by its topics."""

from __future__ import annotations

from typing import Any, Optional

import numpy as np
from sensor_msgs.msg import CameraInfo, CompressedImage

from telex_control.ros.node_handle import NodeHandle

from ..operators.port import CameraPicture, CameraView


class CameraTopics(CameraView):
    """Listens to ``image_raw/compressed`` and ``camera_info`` of a camera.

    Parameters
    ----------
    node : NodeHandle
        Of the camera's namespace, and of nobody else: it ends with the view.
    """

    def __init__(self, node: NodeHandle) -> None:
        self._picture: Optional[CompressedImage] = None
        self._info: Optional[CameraInfo] = None
        self._node = node
        node.subscribe("image_raw/compressed", CompressedImage, self._on_picture)
        node.subscribe("camera_info", CameraInfo, self._on_info)

    def _on_picture(self, message: Any) -> None:
        self._picture = message

    def _on_info(self, message: Any) -> None:
        self._info = message

    def picture(self) -> Optional[CameraPicture]:
        """See `CameraView.picture`."""
        picture, info = self._picture, self._info
        if picture is None or info is None:
            return None
        return CameraPicture(
            picture.header.stamp.to_sec(),
            bytes(picture.data),
            np.array(info.K).reshape(3, 3),
            np.array(info.D),
        )

    def close(self) -> None:
        """See `CameraView.close`."""
        self._node.shutdown()
