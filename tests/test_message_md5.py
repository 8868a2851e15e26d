"""Wire compatibility: the generated messages carry upstream's md5 sums (message_md5.yaml)."""

from __future__ import annotations

import inspect
from importlib import import_module
from pathlib import Path
from typing import Dict, Set, Type

import pytest
import yaml

TABLE: Dict[str, str] = yaml.safe_load(
    Path(__file__).with_name("message_md5.yaml").read_text(encoding="utf-8")
)
PACKAGES = ("control_msgs", "controller_manager_msgs", "tf2_web_republisher")


def generated_classes(package: str) -> Dict[str, Type]:
    """Return every message and service class of a package, by its ROS type name."""
    found = {}
    for kind in ("msg", "srv"):
        try:
            module = import_module(f"{package}.{kind}")
        except ModuleNotFoundError as error:
            if error.name != f"{package}.{kind}":
                raise
            continue
        for _, candidate in inspect.getmembers(module, inspect.isclass):
            # A service module also shows its request and response: no types by themselves.
            if kind == "msg" or hasattr(candidate, "_request_class"):
                found[candidate._type] = candidate
    return found


@pytest.mark.parametrize("ros_type", sorted(TABLE))
def test_md5_equals_upstream(ros_type: str) -> None:
    classes = generated_classes(ros_type.split("/")[0])
    assert ros_type in classes, f"{ros_type} is in the table, but was not generated"
    assert classes[ros_type]._md5sum == TABLE[ros_type]


@pytest.mark.parametrize("package", PACKAGES)
def test_every_generated_type_stands_in_the_table(package: str) -> None:
    unknown: Set[str] = set(generated_classes(package)) - set(TABLE)
    assert not unknown, f"generated, but not in message_md5.yaml: {sorted(unknown)}"


def test_table_covers_these_packages_only() -> None:
    assert {ros_type.split("/")[0] for ros_type in TABLE} == set(PACKAGES)
