"""Starts groups of controllers, and switches between them.

Groups stand in the parameter ``controller_groups`` of this node's namespace, as names to lists of
controllers. Output and exit status are upstream's, except that an unknown group has status 1, and
that controllers for joints which a variant of the robot lacks are left out.
"""

from __future__ import annotations

import argparse
from typing import Any, Collection, Dict, List

import rospy

from ..common.params import ConfigError
from ..manager.client import ControllerManagerClient
from ..manager.controller_joints import controller_joints
from ..urdf.joints import UrdfError, parse_urdf
from ..urdf.transmission_parser import driven_joints
from . import program
from .controller_manager import load, switch


def groups_of(value: Any, name: str) -> Dict[str, List[str]]:
    """Check the parameter ``controller_groups``.

    Parameters
    ----------
    value
        What the parameter server holds.
    name : str
        Full name of the parameter, for messages.

    Raises
    ------
    ConfigError
        It is no mapping of names to lists of names.
    """
    if not isinstance(value, dict):
        raise ConfigError(f"parameter {name} is {value!r}; groups with lists of names are needed")
    for group, names in value.items():
        if not isinstance(names, list) or not all(isinstance(each, str) for each in names):
            raise ConfigError(
                f"parameter {name}/{group} is {names!r}; a list of controller names is needed"
            )
    return value


def absent(names: List[str]) -> List[str]:
    """Those controllers of which the robot has no joint, by their parameters and its description.

    Raises
    ------
    UrdfError
        There is a description, but it cannot be read.
    """
    description = rospy.get_param("robot_description", None)
    if description is None:
        return []
    driven = {each.joint for each in driven_joints(parse_urdf(str(description)))}
    joints = {name: controller_joints(rospy.get_param(name, {})) for name in names}
    return [name for name in names if joints[name] and driven.isdisjoint(joints[name])]


def present(names: List[str], gone: Collection[str]) -> List[str]:
    """Return `names`, each once, without those that are `gone`, and say which."""
    unique = list(dict.fromkeys(names))
    for name in unique:
        if name in gone:
            print(f"Left out: '{name}', for this robot has none of its joints")
    return [name for name in unique if name not in gone]


def list_groups(groups: Dict[str, List[str]]) -> None:
    """Print all groups, sorted, and their controllers."""
    print(f"Number of groups: {len(groups)}")
    for group, names in sorted(groups.items()):
        print(f"  {group}")
        for name in names:
            print(f"      {name}")


def spawn_group(client: ControllerManagerClient, names: List[str]) -> None:
    """Load all controllers of a group, then start each."""
    for name in names:
        load(client, name)
    for name in names:
        switch(client, start=[name])


def switch_group(
    client: ControllerManagerClient,
    groups: Dict[str, List[str]],
    group: str,
    gone: Collection[str] = (),
) -> None:
    """Stop what only other groups have and start what this group has, in one switch.

    Controllers that are `gone` are left out; a group of such alone is not switched to.
    """
    wanted = present(groups[group], gone)
    if not wanted:
        print("Cancel group switching")
        return
    others = {name for names in groups.values() for name in names} - set(wanted)
    states = {each.name: each.state for each in client.list_controllers()}
    for name in wanted:
        if name not in states and not load(client, name):
            print("Cancel group switching")
            return
    switch(
        client,
        start=[name for name in wanted if states.get(name) != "running"],
        stop=[name for name in states if name in others and states[name] == "running"],
    )


def parse(arguments: List[str]) -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(prog="controller_group", description=__doc__.split("\n", 1)[0])
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    commands.add_parser("list", help="list the groups")
    for name, text in (
        ("spawn", "load and start all controllers of a group"),
        ("switch", "start a group and stop what only other groups have"),
    ):
        command = commands.add_parser(name, help=text)
        command.add_argument("group", help="name of the group")
    return parser.parse_args(arguments)


def main() -> None:
    """Carry out one command."""
    options = parse(program.arguments())

    def work() -> int:
        name = rospy.resolve_name("controller_groups")
        try:
            groups = groups_of(rospy.get_param(name, {}), name)
            gone = absent(groups.get(options.group, []) if options.command != "list" else [])
        except (ConfigError, UrdfError) as error:
            rospy.logerr("%s", error)
            return 1
        if options.command == "list":
            list_groups(groups)
        elif not groups.get(options.group):
            rospy.logerr("There is no controller defined in group %s", options.group)
            return 1
        elif options.command == "spawn":
            spawn_group(ControllerManagerClient(), present(groups[options.group], gone))
        else:
            switch_group(ControllerManagerClient(), groups, options.group, gone)
        return 0

    program.run("controller_group", work)
