"""Calls the services of a controller manager from a shell.

Output and exit status are upstream's: what the manager refuses is told in words, with status 0.
"""

from __future__ import annotations

import sys
from typing import Callable, Dict, List, Sequence

from ..manager.client import BEST_EFFORT, ControllerManagerClient
from . import program

USAGE = """Usage: controller_manager COMMAND [NAME...]

Commands:
    load NAME...                   load controllers
    unload NAME...                 unload controllers that do not run
    start NAME...                  start controllers, one after the other
    stop NAME...                   stop controllers, one after the other
    spawn NAME... (sp)             load and start
    kill NAME... (kl)              stop and unload
    list (lc)                      list loaded controllers: 'name' - 'interfaces' ( state )
    list-types (lt)                list controller types
    reload-libraries [--restore]   unload everything and import the controllers' code anew;
                                   --restore loads and starts them again

The manager is looked for in this node's namespace: ROS_NAMESPACE=/telex, or __ns:=/telex."""


def load(client: ControllerManagerClient, name: str) -> bool:
    """Load a controller and say so."""
    ok = client.load(name)
    print(f"Loaded '{name}'" if ok else f"Error when loading '{name}'")
    return ok


def unload(client: ControllerManagerClient, name: str) -> bool:
    """Unload a controller and say so."""
    ok = client.unload(name)
    print(f"Unloaded '{name}' successfully" if ok else f"Error when unloading '{name}'")
    return ok


def switch(
    client: ControllerManagerClient, start: Sequence[str] = (), stop: Sequence[str] = ()
) -> bool:
    """Stop and start controllers, STRICT, in one switch, and say so."""
    to_start, to_stop = list(start), list(stop)
    ok = client.switch(to_start, to_stop)
    if not ok:
        print(f"Error when starting {to_start} and stopping {to_stop}")
        return False
    if to_start:
        print(f"Started {to_start} successfully")
    if to_stop:
        print(f"Stopped {to_stop} successfully")
    return True


def list_controllers(client: ControllerManagerClient) -> None:
    """List the loaded controllers."""
    controllers = client.list_controllers()
    if not controllers:
        print("No controllers are loaded in mechanism control")
    for each in controllers:
        interfaces = dict.fromkeys(claim.hardware_interface for claim in each.claimed_resources)
        print(f"'{each.name}' - '{'+'.join(interfaces)}' ( {each.state} )")


def list_types(client: ControllerManagerClient) -> None:
    """List the controller types."""
    for name in client.list_controller_types():
        print(name)


def reload_libraries(
    client: ControllerManagerClient, force_kill: bool, restore: bool = False
) -> bool:
    """Import the controllers' code anew, and say so.

    Parameters
    ----------
    force_kill : bool
        Unload what is loaded first; without it, nothing may be loaded.
    restore : bool
        Load, and start what was running, again.
    """
    print(f"Restore: {restore}")
    before = client.list_controllers() if restore else []
    ok = client.reload_libraries(force_kill)
    if ok:
        print("Successfully reloaded libraries")
    else:
        print("Failed to reload libraries. Do you still have controllers loaded?")
    if restore:
        for controller in before:
            client.load(controller.name)
        running = [controller.name for controller in before if controller.state == "running"]
        client.switch(running, [], BEST_EFFORT)
        print("Controllers restored to original state")
    return ok


def _for_each(
    *actions: Callable[[ControllerManagerClient, str], bool],
) -> Callable[[ControllerManagerClient, List[str]], None]:
    def run(client: ControllerManagerClient, names: List[str]) -> None:
        for action in actions:
            for name in names:
                action(client, name)

    return run


def _start(client: ControllerManagerClient, name: str) -> bool:
    return switch(client, start=[name])


def _stop(client: ControllerManagerClient, name: str) -> bool:
    return switch(client, stop=[name])


def _list(client: ControllerManagerClient, arguments: List[str]) -> None:
    list_controllers(client)


def _list_types(client: ControllerManagerClient, arguments: List[str]) -> None:
    list_types(client)


def _reload(client: ControllerManagerClient, arguments: List[str]) -> None:
    reload_libraries(client, force_kill=True, restore="--restore" in arguments)


COMMANDS: Dict[str, Callable[[ControllerManagerClient, List[str]], None]] = {
    "load": _for_each(load),
    "unload": _for_each(unload),
    "start": _for_each(_start),
    "stop": _for_each(_stop),
    "spawn": _for_each(load, _start),
    "sp": _for_each(load, _start),
    "kill": _for_each(_stop, unload),
    "kl": _for_each(_stop, unload),
    "list": _list,
    "lc": _list,
    "list-types": _list_types,
    "lt": _list_types,
    "reload-libraries": _reload,
}


def main() -> None:
    """Carry out one command."""
    arguments = program.arguments()
    if not arguments or arguments[0] in ("-h", "--help"):
        print(USAGE)
        sys.exit(0)
    command = COMMANDS.get(arguments[0])
    if command is None:
        print(USAGE)
        sys.exit(1)

    def work() -> int:
        command(ControllerManagerClient(), arguments[1:])
        return 0

    program.run("controller_manager", work)
