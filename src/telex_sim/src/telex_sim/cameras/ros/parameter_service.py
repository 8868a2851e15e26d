"""The service that changes parameters while the node runs."""

from __future__ import annotations

import dataclasses
import json
import threading
from typing import Any, Dict, Iterable

import rospy
from std_msgs.msg import String
from telex_msgs.srv import ConfigureCamera, ConfigureCameraRequest, ConfigureCameraResponse

from telex_control.common.params import ConfigError

from ..cameras_config import OVERVIEW, CamerasConfig
from .camera_topics import CameraStream
from .live_parameters import as_yaml, changed, plain

# Of what all cameras have in common.
_COMMON = ("max_pose_age", "quality", "shadow_period", "shadow_radius")

# Of a camera: what its topics or its place in the scene depend on.
_FIXED = ("follow", "frame", "smoothing", "start", "zoom_max")


class CameraService:
    """Serves ``cameras/configure``, and keeps the parameter server as things are.

    ``cameras/settings`` (latched) tells all of them but the overview's, at the start and after each
    change: recordings of what an operator saw need no other place to look.

    Parameters
    ----------
    streams
        The cameras.
    namespace
        Of a further robot; its parameters stand in ``cameras`` there, and what all cameras have in
        common is not set by it.

    Attributes
    ----------
    config : CamerasConfig
        With what has been changed of what all cameras have in common; replaced as a whole.
    """

    def __init__(
        self, config: CamerasConfig, streams: Iterable[CameraStream], namespace: str = ""
    ) -> None:
        self.config = config
        prefix = f"{namespace}/" if namespace else ""
        self._parameters = f"{prefix}cameras/" if namespace else "~"
        self._sets_common = not namespace
        self._streams = {stream.name: stream for stream in streams}
        self._changing = threading.Lock()
        self._told = rospy.Publisher(f"{prefix}cameras/settings", String, queue_size=1, latch=True)
        self._tell()
        self._service = rospy.Service(f"{prefix}cameras/configure", ConfigureCamera, self._serve)

    def _serve(self, request: ConfigureCameraRequest) -> ConfigureCameraResponse:
        try:
            with self._changing:
                values = self._configure(request.camera, request.parameters)
                self._tell()
        except ConfigError as error:
            rospy.logwarn("cameras/configure: %s", error)
            return ConfigureCameraResponse(False, str(error), "")
        return ConfigureCameraResponse(True, "", as_yaml(values))

    def _tell(self) -> None:
        made = {key: getattr(self.config, key) for key in _COMMON}
        made["cameras"] = {
            name: dataclasses.asdict(stream.config)
            for name, stream in sorted(self._streams.items())
            if name != OVERVIEW
        }
        self._told.publish(json.dumps(plain(made), sort_keys=True))

    def _configure(self, name: str, text: str) -> Dict[str, Any]:
        if not name and self._sets_common:
            names = {field.name for field in dataclasses.fields(self.config)}
            self.config = changed(self.config, text, names.difference(_COMMON))
            values = {key: getattr(self.config, key) for key in _COMMON}
            self._store("", values)
            return values
        if name not in self._streams:
            raise ConfigError(
                f"camera is '{name}'; {', '.join(sorted(self._streams))} are possible"
                + (", or nothing for what all have in common" if self._sets_common else "")
            )
        stream = self._streams[name]
        stream.configure(changed(stream.config, text, _FIXED))
        values = dataclasses.asdict(stream.config)
        self._store("overview/" if name == OVERVIEW else f"cameras/{name}/", values)
        return values

    def _store(self, prefix: str, values: Dict[str, Any]) -> None:
        # A node that is started anew, because it died, goes on as it was.
        for key, value in plain(values).items():
            rospy.set_param(f"{self._parameters}{prefix}{key}", value)
