"""Several scripted operators at once: they take turns at each moment, always in the same order."""

from __future__ import annotations

import threading
from typing import Callable, List, Optional, Sequence


class LeftError(Exception):
    """Nobody waits for what an operator still does: the trial is over."""


class _Operator:
    """One operator, in a thread that runs only while the others, and the simulation, stand."""

    def __init__(self, work: Callable[[], None]) -> None:
        self._work = work
        self._go, self._done = threading.Semaphore(0), threading.Semaphore(0)
        self._thread = threading.Thread(target=self._run, name="operator", daemon=True)
        self.steps = 0
        self.active = True
        self.left = False
        self.error: Optional[BaseException] = None
        self._thread.start()

    def _run(self) -> None:
        self._go.acquire()
        try:
            if not self.left:
                self._work()
        except LeftError:
            pass
        except BaseException as error:  # whatever it is: it belongs to who waits for it
            self.error = error
        self.active = False
        self._done.release()

    def resume(self) -> None:
        """Let him work until he lets time pass, or has done."""
        self._go.release()
        self._done.acquire()
        if self.error is not None:
            raise self.error

    def wait(self, steps: int) -> None:
        """Let so many steps pass; in his own thread."""
        self.steps = steps
        self._done.release()
        self._go.acquire()
        if self.left:
            raise LeftError

    def leave(self) -> None:
        """Have him end, if he has not."""
        if self.active:
            self.left = True
            self._go.release()
            self._done.acquire()
        self._thread.join()


class Together:
    """Operators who share a simulation.

    Parameters
    ----------
    advance : callable
        Lets so many steps of the simulation pass.
    """

    def __init__(self, advance: Callable[[int], None]) -> None:
        self._advance = advance
        self._working: Optional[_Operator] = None

    def wait(self, steps: int) -> None:
        """Let so many steps pass: as all operators want it where one of them asks, else at once.

        Raises
        ------
        LeftError
            The one who asks is to end.
        """
        if self._working is None:
            self._advance(steps)
        else:
            self._working.wait(steps)

    def run(self, works: Sequence[Callable[[], None]]) -> None:
        """Let all work until each has done; what one raises ends it for all."""
        operators = [_Operator(work) for work in works]
        try:
            while True:
                active = self._turn(operators)
                if not active:
                    return
                steps = min(each.steps for each in active)
                self._advance(steps)
                for each in active:
                    each.steps -= steps
        finally:
            for each in operators:
                each.leave()

    def _turn(self, operators: Sequence[_Operator]) -> List[_Operator]:
        """Let those work who have nothing to wait for; returns who has not done yet."""
        for each in operators:
            if each.active and each.steps <= 0:
                self._working = each
                try:
                    each.resume()
                finally:
                    self._working = None
        return [each for each in operators if each.active]
