"""Bookmarks of a simulation: states to go back to, by name."""

from __future__ import annotations

from typing import Any, Dict, List, NamedTuple

from telex_control.common.params import ConfigError

from .simulation import Simulation

MOST = 10
"""Bookmarks that there are at once; a further one takes the place of the oldest."""
_LONGEST = 80
"""Of a name, in characters."""


class _Bookmark(NamedTuple):
    """A state, and what it was saved of."""

    structure: int
    state: Any


class Bookmarks:
    """The newest bookmarks of one simulation; only the simulation's thread may use them.

    They end when a scene is loaded, an object or a robot comes or goes, and are then refused by
    their names. A reset keeps them, unless it brings objects back or takes some away.
    """

    def __init__(self, simulation: Simulation) -> None:
        self._simulation = simulation
        # Those that there are, oldest first; names of ended ones, and what ended them.
        self._kept: Dict[str, _Bookmark] = {}
        self._ended: Dict[str, str] = {}
        self._structure = simulation.structure
        self._count = 0

    def names(self) -> List[str]:
        """Names of those that can be restored, oldest first."""
        self._end()
        return list(self._kept)

    def save(self, name: str = "", replaces: str = "") -> str:
        """Save the present state.

        Parameters
        ----------
        name : str
            One of the same name is replaced. Empty: a number that counts up.
        replaces : str
            Name of one that goes for it, if it is still there. Empty: none does.

        Returns
        -------
        str
            Its name.

        Raises
        ------
        ConfigError
            The name is too long, or cannot be printed.
        """
        if len(name) > _LONGEST or not name.isprintable():
            raise ConfigError(
                f"name is {name[:_LONGEST]!r}; at most {_LONGEST} characters that can be printed "
                "are possible"
            )
        self._end()
        while not name:
            self._count += 1
            if str(self._count) not in self._kept:
                name = str(self._count)
        simulation = self._simulation
        state = simulation.save_state()
        self._kept.pop(name, None)
        self._ended.pop(name, None)
        if self._kept.pop(replaces, None) is not None:
            self._note_end(replaces, f"'{name}' has taken its place")
        self._kept[name] = _Bookmark(simulation.structure, state)
        while len(self._kept) > MOST:
            oldest = next(iter(self._kept))
            del self._kept[oldest]
            self._note_end(oldest, f"{MOST} newer ones have taken its place")
        return name

    def restore(self, name: str = "") -> str:
        """Go back to a bookmark; see `Simulation.restore_state`.

        Parameters
        ----------
        name : str
            Empty: the newest.

        Returns
        -------
        str
            Its name.

        Raises
        ------
        ConfigError
            There is none, or it has ended; nothing has changed.
        """
        self._end()
        if not name:
            name = next(reversed(self._kept), "")
        if name not in self._kept:
            raise ConfigError(self._refusal(name))
        self._simulation.restore_state(self._kept[name].state)
        return name

    def _refusal(self, name: str) -> str:
        there = ", ".join(f"'{each}'" for each in self._kept) or "none"
        if not name:
            name = next(reversed(self._ended), "")
        if not name:
            return "there is no bookmark to go back to; sim/bookmark sets one"
        why = self._ended.get(name)
        if why is None:
            return f"name is '{name}'; bookmarks that there are: {there}"
        return f"bookmark '{name}' has ended: {why}; bookmarks that there are: {there}"

    def _end(self) -> None:
        """Let those go that belong to other objects or robots than there are now."""
        structure = self._simulation.structure
        if structure == self._structure:
            return
        self._structure = structure
        for name in self._kept:
            self._note_end(name, self._simulation.last_change)
        self._kept.clear()

    def _note_end(self, name: str, why: str) -> None:
        self._ended.pop(name, None)
        self._ended[name] = why
        while len(self._ended) > MOST:
            del self._ended[next(iter(self._ended))]
