"""Private parameters of the two servers, read once and validated."""

from __future__ import annotations

import dataclasses
import math
from typing import Any, Dict, List, Mapping, Tuple, Type, TypeVar

Config = TypeVar("Config")

OWN_PARAMETERS = ("url",)
"""Private parameters that a server sets for others to read."""


class ConfigError(ValueError):
    """A parameter that cannot be used; the text names it, its value and what would be right."""


@dataclasses.dataclass(frozen=True)
class Whole:
    """An integer between two bounds, both allowed."""

    minimum: int
    maximum: int

    def read(self, value: Any) -> int:
        """Return the value, or raise ValueError with what would be right."""
        if isinstance(value, bool) or not isinstance(value, int):
            raise ValueError(f"must be an integer from {self.minimum} to {self.maximum}")
        if not self.minimum <= value <= self.maximum:
            raise ValueError(f"must lie between {self.minimum} and {self.maximum}")
        return value


@dataclasses.dataclass(frozen=True)
class Real:
    """A finite number between two bounds, both allowed."""

    minimum: float
    maximum: float

    def read(self, value: Any) -> float:
        """Return the value, or raise ValueError with what would be right."""
        number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if not number or not math.isfinite(value) or not self.minimum <= value <= self.maximum:
            raise ValueError(f"must be a number from {self.minimum:g} to {self.maximum:g}")
        return float(value)


@dataclasses.dataclass(frozen=True)
class Text:
    """A string that is not empty."""

    def read(self, value: Any) -> str:
        """Return the value, or raise ValueError with what would be right."""
        if not isinstance(value, str) or not value:
            raise ValueError("must be a string that is not empty")
        return value


@dataclasses.dataclass(frozen=True)
class Texts:
    """A list of strings, perhaps empty."""

    def read(self, value: Any) -> Tuple[str, ...]:
        """Return the value, or raise ValueError with what would be right."""
        if not isinstance(value, (list, tuple)) or not all(isinstance(v, str) for v in value):
            raise ValueError("must be a list of strings")
        return tuple(value)


def setting(default: Any, check: Any) -> Any:
    """Declare a field of a configuration dataclass: its default and the check of its value."""
    return dataclasses.field(default=default, metadata={"check": check})


def load_config(config_class: Type[Config], values: Mapping[str, Any], where: str) -> Config:
    """Read a configuration out of private parameters.

    Parameters
    ----------
    config_class
        Frozen dataclass whose fields are all made by `setting`.
    values
        The private parameters; missing ones take their default.
    where
        Name of the node, for messages.

    Raises
    ------
    ConfigError
        A parameter is unknown, or its value cannot be used.
    """
    if not isinstance(values, Mapping):
        raise ConfigError(f"{where}: the private parameters must be a dictionary, not {values!r}")
    fields = {field.name: field for field in dataclasses.fields(config_class)}  # type: ignore[arg-type]
    unknown: List[str] = sorted(set(values) - set(fields) - set(OWN_PARAMETERS))
    if unknown:
        known = ", ".join(sorted(fields))
        raise ConfigError(f"{where}/{unknown[0]}: unknown parameter; known are {known}")
    read: Dict[str, Any] = {}
    for name, field in fields.items():
        if name in values:
            try:
                read[name] = field.metadata["check"].read(values[name])
            except ValueError as error:
                raise ConfigError(f"{where}/{name}: {values[name]!r} {error}") from None
    return config_class(**read)


@dataclasses.dataclass(frozen=True)
class VideoServerConfig:
    """Parameters of the video server; see config/video_server.yaml for their meaning."""

    address: str = setting("127.0.0.1", Text())
    port: int = setting(8080, Whole(0, 65535))
    quality: int = setting(95, Whole(1, 100))
    max_size: int = setting(4096, Whole(16, 16384))
    send_buffer: int = setting(131072, Whole(4096, 16777216))
    max_in_flight: int = setting(0, Whole(0, 16777216))
    stall_timeout: float = setting(5.0, Real(0.5, 3600.0))
    snapshot_timeout: float = setting(5.0, Real(0.1, 60.0))
    main_camera: str = setting("front", Text())
    rosbridge: str = setting("rosbridge", Text())


@dataclasses.dataclass(frozen=True)
class RosbridgeConfig:
    """Parameters of the bridge; see config/rosbridge.yaml for their meaning."""

    address: str = setting("127.0.0.1", Text())
    port: int = setting(9090, Whole(0, 65535))
    allowed_origins: Tuple[str, ...] = setting((), Texts())
    max_message_size: int = setting(1048576, Whole(1024, 268435456))
    max_queue_length: int = setting(100, Whole(1, 10000))
    max_queue_bytes: int = setting(4194304, Whole(65536, 1073741824))
    max_subscriptions: int = setting(200, Whole(1, 100000))
    max_service_calls: int = setting(16, Whole(1, 1000))
    service_timeout: float = setting(30.0, Real(0.1, 3600.0))
    connect_timeout: float = setting(0.5, Real(0.0, 10.0))
    ping_interval: float = setting(5.0, Real(0.2, 600.0))
    send_buffer: int = setting(65536, Whole(4096, 16777216))
    max_in_flight: int = setting(32768, Whole(0, 16777216))
