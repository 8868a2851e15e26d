"""What launch files may not say."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

from roslaunch.config import ROSLaunchConfig
from roslaunch.xmlloader import XmlLoader

SOURCES = Path(__file__).resolve().parents[1] / "src"
FILES = sorted(SOURCES.glob("*/launch/*.launch"))


def test_programs_are_not_looked_for_within_quotes():
    """roslaunch takes the quote for a part of the path, and finds none of an install space."""
    assert FILES
    quoted = re.compile(r"'\$\(find \w+\)/nodes/")
    assert not [file.name for file in FILES if quoted.search(file.read_text())]


def test_a_station_takes_what_bringup_takes_with_the_same_defaults():
    """roslaunch passes on what an included file asks for only where the including one names it."""

    def arguments(package, name):
        root = ElementTree.parse(SOURCES / package / "launch" / name).getroot()
        return {
            each.get("name"): (each.get("default"), each.get("doc")) for each in root.findall("arg")
        }

    bringup = arguments("telex_teleop", "bringup.launch")
    station = arguments("telex_training", "station.launch")
    assert {name: station.get(name) for name in bringup} == bringup


def test_a_robot_of_ones_own_finds_nothing_of_the_one_before():
    """On a master that runs on, parameters outlive the nodes that they were for."""
    rover = SOURCES.parent / "docs" / "examples" / "rover"
    config = ROSLaunchConfig()
    given = [f"model:={rover}/rover.urdf", f"controllers:={rover}/controllers.yaml", "ns:=rover"]
    launch = SOURCES / "telex_teleop" / "launch" / "own_robot.launch"
    XmlLoader(resolve_anon=False).load(str(launch), config, argv=given, verbose=False)
    assert config.clear_params == ["/rover/"]
