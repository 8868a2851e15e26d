"""Reading of YAML files into dataclasses."""

from __future__ import annotations

import os
from typing import ClassVar, Type, TypeVar

import yaml

from telex_control.common.file_catalog import package_path
from telex_control.common.params import ConfigError, read_struct
from telex_control.common.yaml_files import load_yaml

Config = TypeVar("Config", bound="FromFile")


class FromFile:
    """Base of dataclasses that a YAML file holds; one with the package has the name `SHIPPED`."""

    SHIPPED: ClassVar[str]

    @classmethod
    def read(cls: Type[Config], path: str = "") -> Config:
        """Read a file; an empty path stands for the shipped one.

        Raises
        ------
        telex_control.common.params.ConfigError
            It cannot be read or is wrong; the message begins with the path.
        """
        path = path or shipped_file(cls.SHIPPED)
        try:
            with open(path, encoding="utf-8") as file:
                content = load_yaml(file)
        except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
            raise ConfigError(f"{path}: cannot be read: {error}") from error
        try:
            return read_struct(cls, content)
        except ConfigError as error:
            raise ConfigError(f"{path}: {error}") from None


def shipped_file(name: str) -> str:
    """Return the path of a file of the package's folder ``config``."""
    return os.path.join(package_path("telex_teleop"), "config", name)
