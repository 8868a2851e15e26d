"""Private parameters of the two servers, read once and validated."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, Mapping, Tuple, Type, TypeVar

from telex_control.common.params import (
    read_config,
    require,
    require_choice,
    require_range,
    require_text,
)

from .tokens import is_loopback

Config = TypeVar("Config")

_ROBOT = re.compile(r"[A-Za-z][A-Za-z0-9_]*")

STREAM_TYPES = ("mjpeg", "ros_compressed", "png")
"""Types of streams that the video server offers."""

OWN_PARAMETERS = ("url", "mounts", "exam")
"""Private parameters that change while a server runs: what it sets for others to read, and what
others set for it."""


def read_server_config(kind: Type[Config], params: Any, name: str) -> Config:
    """Read the private parameters of a server, except those that change.

    Parameters
    ----------
    kind
        Dataclass to read them into.
    params
        The private parameters; missing ones take their default.
    name
        Name of the node, for messages.

    Raises
    ------
    telex_control.common.params.ConfigError
        A parameter is unknown, or its value cannot be used.
    """
    if isinstance(params, Mapping):
        for gone in ("token", "instructor_token"):
            # Its value is not shown: nobody is to read it here, too.
            require(
                gone not in params,
                f"parameter {name}/{gone} is not taken any more, for every program can read "
                f"parameters; write the token into a file, and give {gone}_file",
            )
        params = {key: value for key, value in params.items() if key not in OWN_PARAMETERS}
    return read_config(kind, params, name)


@dataclass(frozen=True)
class VideoServerConfig:
    """Parameters of the video server; see config/video_server.yaml for their meaning."""

    address: str = "127.0.0.1"
    port: int = 8080
    token_file: str = ""
    instructor_token_file: str = ""
    quality: int = 95
    default_stream_type: str = "mjpeg"
    publish_rate: float = -1.0
    max_size: int = 1920
    max_encoded: int = 16
    send_buffer: int = 131072
    max_in_flight: int = 0
    stall_timeout: float = 5.0
    snapshot_timeout: float = 5.0
    ping_interval: float = 10.0
    main_camera: str = "front"
    hidden_cameras: Tuple[str, ...] = ("overview",)
    main_rate: float = 30.0
    thumbnail_rate: float = 10.0
    thumbnail_width: int = 320
    preview_rate: float = 10.0
    max_upload: int = 16777216
    handler_timeout: float = 30.0
    rosbridge: str = "rosbridge"
    robots: Tuple[str, ...] = ()
    actions: str = ""
    joy_map: str = ""

    def __post_init__(self) -> None:
        require_text(self, "address")
        require_range(self, "port", 0, 65535)
        require_range(self, "quality", 1, 100)
        require_choice(self, "default_stream_type", STREAM_TYPES)
        require_range(self, "publish_rate", -1.0, 1000.0)
        require_range(self, "max_size", 16, 16384)
        require_range(self, "max_encoded", 2, 1000)
        require_range(self, "send_buffer", 4096, 16777216)
        require_range(self, "max_in_flight", 0, 16777216)
        require_range(self, "stall_timeout", 0.5, 3600.0)
        require_range(self, "snapshot_timeout", 0.1, 60.0)
        require_range(self, "ping_interval", 0.2, 600.0)
        require_text(self, "main_camera")
        require_range(self, "main_rate", 0.1, 1000.0)
        require_range(self, "thumbnail_rate", 0.1, 1000.0)
        require_range(self, "thumbnail_width", 16, self.max_size)
        require_range(self, "preview_rate", 0.0, 1000.0)
        require_range(self, "max_upload", 0, 2147483647)
        require_range(self, "handler_timeout", 0.1, 3600.0)
        require_text(self, "rosbridge")
        for robot in self.robots:
            require(
                _ROBOT.fullmatch(robot) is not None and self.robots.count(robot) == 1,
                f"robots has {robot!r}; names of namespaces are needed, each once",
            )


@dataclass(frozen=True)
class RosbridgeConfig:
    """Parameters of the bridge; see config/rosbridge.yaml for their meaning."""

    address: str = "127.0.0.1"
    port: int = 9090
    allowed_origins: Tuple[str, ...] = ()
    token_file: str = ""
    instructor_token_file: str = ""
    rights: str = ""
    exam_rights: str = ""
    plain: bool = False
    e_stop_topic: str = "e_stop"
    max_command_age: float = 0.15
    max_learned_delay: float = 1.0
    max_clients: int = 64
    reserved_clients: int = 4
    max_message_size: int = 1048576
    max_queue_length: int = 100
    max_queue_bytes: int = 4194304
    max_subscriptions: int = 200
    max_service_calls: int = 16
    max_services: int = 50
    service_timeout: float = 60.0
    connect_timeout: float = 0.5
    action_timeout: float = 5.0
    ping_interval: float = 5.0
    send_buffer: int = 65536
    max_in_flight: int = 32768
    link: str = "perfect"
    link_profiles: str = ""

    def __post_init__(self) -> None:
        require_text(self, "address")
        require_range(self, "port", 0, 65535)
        require(
            not self.plain or is_loopback(self.address),
            f"plain is true and address {self.address!r}; a bridge that others reach has to tell "
            "operators from instructors: set plain to false, or address to 127.0.0.1",
        )
        require_text(self, "e_stop_topic")
        require_range(self, "max_command_age", 0.01, 60.0)
        require_range(self, "max_learned_delay", 0.0, 60.0)
        require_range(self, "max_clients", 1, 10000)
        require_range(self, "reserved_clients", 0, 10000)
        require_range(self, "max_services", 1, 10000)
        require_range(self, "max_message_size", 1024, 268435456)
        require_range(self, "max_queue_length", 1, 10000)
        require_range(self, "max_queue_bytes", 65536, 1073741824)
        require_range(self, "max_subscriptions", 1, 100000)
        require_range(self, "max_service_calls", 1, 1000)
        require_range(self, "service_timeout", 0.1, 3600.0)
        require_range(self, "connect_timeout", 0.0, 10.0)
        require_range(self, "action_timeout", 0.0, 60.0)
        require_range(self, "ping_interval", 0.2, 600.0)
        require_range(self, "send_buffer", 4096, 16777216)
        require_range(self, "max_in_flight", 0, 16777216)
        require_text(self, "link")

    def depth(self, length: int) -> int:
        """Return how many messages may wait; rosbridge's 0 means that the client does not mind."""
        return min(length, self.max_queue_length) if length else self.max_queue_length
