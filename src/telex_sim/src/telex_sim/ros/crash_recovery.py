"""Recovery of a simulator that crashed: its clock and its emergency stop."""

from __future__ import annotations

from telex_control.ros.run_memory import RunMemory

from ..engine.simulation import Simulation

__all__ = ["CrashRecovery"]


class CrashRecovery:
    """Restores what must survive a crash, and keeps it for the next one.

    The scene begins anew, as after a reset. Sim time goes on, since tf, bags and timers do not
    survive a clock that jumps back, and an emergency stop stays set.

    Parameters
    ----------
    memory : RunMemory

    Attributes
    ----------
    happened : bool
        Whether another simulator has crashed before this one.
    resets : int
        Resets until now; to others a crash is one.
    """

    def __init__(self, memory: RunMemory) -> None:
        self._memory = memory
        self._noted = (0, False, -1)
        self.happened = False
        self.resets = 0

    def restore(self, simulation: Simulation) -> None:
        """Go on after the simulator before, if that crashed; the simulation has not begun yet."""
        left = self._memory.recall()
        steps, resets = left.get("steps"), left.get("resets")
        if not (isinstance(steps, int) and isinstance(resets, int)):
            return
        self.happened = True
        self.resets = resets + 1
        # A whole second later than what was kept: nothing that was said before the crash has a
        # later stamp, and all rates keep the places that they have after a first start.
        per_second = round(1.0 / simulation.config.timing.step_size)
        simulation.steps = (steps // per_second + 2) * per_second
        if left.get("e_stop") is True:
            simulation.request_e_stop(True)

    def note(self, simulation: Simulation, resets: int) -> None:
        """Keep the present state, where it is not that of just now; to be called often."""
        e_stop = simulation.robots[0].e_stop_wanted
        steps, *rest = self._noted
        # The clock goes on a whole second later at least than what is kept.
        soon = 0 <= simulation.steps - steps < round(0.5 / simulation.config.timing.step_size)
        if soon and rest == [e_stop, resets]:
            return
        self._noted = (simulation.steps, e_stop, resets)
        self._memory.keep(steps=simulation.steps, e_stop=e_stop, resets=resets)

    def forget(self) -> None:
        """Leave nothing: the simulator ends in order."""
        self._memory.forget()
