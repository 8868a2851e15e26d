"""Names of other robots on the master: a bridge touches none of them, whoever asks."""

from __future__ import annotations

from typing import Callable, Iterable, Optional, Set

from ...rights import NamePatterns

_MARK = "/controller_manager/list_controllers"
"""Service that every robot has in its namespace."""

_PARTS = (
    "/*e_stop",
    "/*_teleop/*",
    "/*_controller/*",
    "/*controller_manager/*",
    "/*cameras/*",
    "/*lamps/*",
    "/*/sim/*",
    "/*/bridge/*",
    "/*/link/*",
    "/*/training/*",
    "/*/console/*",
)
"""Names that only a robot has, wherever they stand: whether it is known yet or not."""

_SIMULATOR = tuple(
    f"!/*/sim/{name}"
    for name in (
        "pause",
        "unpause",
        "step",
        "reset",
        "bookmark",
        "restore",
        "list_bookmarks",
        "list_scenes",
        "load_scene",
        "list_objects",
        "find_place",
        "spawn",
        "move",
        "delete",
        "set_light",
        "add_robot",
        "remove_robot",
    )
)
"""Services of the simulator that all robots share; the rights say who may call them."""

_CHANGES = ("publish", "call", "serve", "set")
"""Uses that change something: of these, a name's form alone tells."""


class OtherRobots:
    """Knows which names are another robot's, by their form and by what the master has.

    Parameters
    ----------
    namespace
        Of the bridge's own robot, with slashes around it.

    Attributes
    ----------
    changed
        Called when another robot has come.
    """

    def __init__(self, namespace: str) -> None:
        self._namespace = namespace
        self._found: Set[str] = set()
        self._parts = NamePatterns(_PARTS, namespace)
        self._shared = NamePatterns(("/*", *_SIMULATOR), namespace)
        self.changed: Callable[[], None] = lambda: None

    def note(self, services: Iterable[str]) -> None:
        """Learn of robots by all services of the master. One that goes is not forgotten."""
        found = {name[: -len(_MARK)] + "/" for name in services if name.endswith(_MARK)}
        new = found - self._found - {self._namespace, "/"}
        if new:
            self._found |= new
            self.changed()

    def owns(self, use: str, name: str) -> bool:
        """Tell whether a use is of what is another robot's.

        Parameters
        ----------
        use
            As the lists of rights are called.
        name
            Global.
        """
        if use == "call" and not self._shared.match(name):
            return False
        whole = name.rstrip("/") + "/"
        if use == "set" and any(robot.startswith(whole) for robot in self._found):
            return True
        robot = self._robot_of(name)
        if robot is not None:
            return robot != self._namespace
        return use in _CHANGES and self._parts.match(name)

    def _robot_of(self, name: str) -> Optional[str]:
        """Return the namespace of the known robot to which a name belongs, if there is one."""
        robots = [each for each in (self._namespace, *self._found) if name.startswith(each)]
        return max(robots, key=len) if robots else None

    def refusal(self, name: str) -> str:
        """Say that a name is another robot's, and where it may be used."""
        own = self._namespace.rstrip("/") or "/"
        return (
            f"{name[:200]} is another robot's, and this bridge touches nothing but {own}; ask the "
            "bridge of that robot"
        )
