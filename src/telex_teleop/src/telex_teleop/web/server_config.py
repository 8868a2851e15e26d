"""Private parameters of the two servers, read once and validated."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, Mapping, Tuple, Type, TypeVar

from telex_control.common.params import (
    Declared,
    choice,
    number,
    read_config,
    require,
    word,
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
class VideoServerConfig(Declared):
    """Parameters of the video server; see config/video_server.yaml for their meaning."""

    address: str = word("127.0.0.1")
    port: int = number(8080, "", 0, 65535)
    token_file: str = ""
    instructor_token_file: str = ""
    quality: int = number(95, "", 1, 100)
    default_stream_type: str = choice("mjpeg", STREAM_TYPES)
    publish_rate: float = number(-1.0, "", -1.0, 1000.0)
    max_size: int = number(1920, "", 16, 16384)
    max_encoded: int = number(16, "", 2, 1000)
    send_buffer: int = number(131072, "", 4096, 16777216)
    max_in_flight: int = number(0, "", 0, 16777216)
    stall_timeout: float = number(5.0, "", 0.5, 3600.0)
    snapshot_timeout: float = number(5.0, "", 0.1, 60.0)
    ping_interval: float = number(10.0, "", 0.2, 600.0)
    main_camera: str = word("front")
    hidden_cameras: Tuple[str, ...] = ("overview",)
    main_rate: float = number(30.0, "", 0.1, 1000.0)
    thumbnail_rate: float = number(10.0, "", 0.1, 1000.0)
    thumbnail_width: int = number(320, "", 16, lambda own: own.max_size)
    preview_rate: float = number(10.0, "", 0.0, 1000.0)
    max_upload: int = number(16777216, "", 0, 2147483647)
    handler_timeout: float = number(30.0, "", 0.1, 3600.0)
    rosbridge: str = word("rosbridge")
    robots: Tuple[str, ...] = ()
    actions: str = ""
    joy_map: str = ""

    def check(self) -> None:
        """Check the names of robots; see `Declared.check`."""
        for robot in self.robots:
            require(
                _ROBOT.fullmatch(robot) is not None and self.robots.count(robot) == 1,
                f"robots has {robot!r}; names of namespaces are needed, each once",
            )


@dataclass(frozen=True)
class RosbridgeConfig(Declared):
    """Parameters of the bridge; see config/rosbridge.yaml for their meaning."""

    address: str = word("127.0.0.1")
    port: int = number(9090, "", 0, 65535)
    allowed_origins: Tuple[str, ...] = ()
    token_file: str = ""
    instructor_token_file: str = ""
    rights: str = ""
    exam_rights: str = ""
    plain: bool = False
    e_stop_topic: str = word("e_stop")
    max_command_age: float = number(0.15, "", 0.01, 60.0)
    max_learned_delay: float = number(1.0, "", 0.0, 60.0)
    max_clients: int = number(64, "", 1, 10000)
    reserved_clients: int = number(4, "", 0, 10000)
    max_message_size: int = number(1048576, "", 1024, 268435456)
    max_queue_length: int = number(100, "", 1, 10000)
    max_queue_bytes: int = number(4194304, "", 65536, 1073741824)
    max_subscriptions: int = number(200, "", 1, 100000)
    max_service_calls: int = number(16, "", 1, 1000)
    max_services: int = number(50, "", 1, 10000)
    service_timeout: float = number(60.0, "", 0.1, 3600.0)
    connect_timeout: float = number(0.5, "", 0.0, 10.0)
    action_timeout: float = number(5.0, "", 0.0, 60.0)
    ping_interval: float = number(5.0, "", 0.2, 600.0)
    send_buffer: int = number(65536, "", 4096, 16777216)
    max_in_flight: int = number(32768, "", 0, 16777216)
    link: str = word("perfect")
    link_profiles: str = ""
    simulator: str = ""

    def check(self) -> None:
        """Check what concerns several of them; see `Declared.check`."""
        require(
            not self.plain or is_loopback(self.address),
            f"plain is true and address {self.address!r}; a bridge that others reach has to tell "
            "operators from instructors: set plain to false, or address to 127.0.0.1",
        )

    def depth(self, length: int) -> int:
        """Return how many messages may wait; rosbridge's 0 means that the client does not mind."""
        return min(length, self.max_queue_length) if length else self.max_queue_length
