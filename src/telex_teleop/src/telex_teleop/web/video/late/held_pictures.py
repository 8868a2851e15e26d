"""Pictures that one client gets as late as the line lets them through."""

from __future__ import annotations

from typing import Callable, Hashable, Optional

from ...line.line import Line
from ...line.picture_line import PictureLine
from ...link.waits import LinePump
from ..pictures import EncodedPicture
from ..viewers import Viewer
from .pacer import Pacer


class LateViewer:
    """Offers a viewer its pictures when they have passed the line.

    Parameters
    ----------
    rate
        Most pictures per second that it takes; None: every one. More need not be under way.
    takes
        Tells whether it uses what it gets, however late.
    """

    def __init__(
        self,
        viewer: Viewer,
        held: HeldPictures,
        rate: Optional[float],
        takes: Callable[[], bool],
    ) -> None:
        self._viewer = viewer
        self._held = held
        self._pacer = Pacer(rate)
        self._takes = takes

    @property
    def client(self) -> Hashable:
        """Whose share of the encoder's time its pictures take."""
        return self._viewer.client

    def wants(self) -> bool:
        """Tell whether a picture would be sent now."""
        if self._held.passes:
            return self._viewer.wants()
        return self._pacer.is_due(self._held.clock()) and self._takes()

    def offer(self, picture: EncodedPicture) -> None:
        """Send a picture, which the viewer gets when it has arrived."""
        if self._held.passes:
            self._viewer.offer(picture)
            return
        now = self._held.clock()
        if self._pacer.is_due(now):
            self._pacer.sent(now)
            self._held.send(self, picture)

    def arrive(self, picture: EncodedPicture) -> None:
        """Give the viewer a picture that has passed the line."""
        self._viewer.offer(picture)

    def forget(self) -> None:
        """Lose what is under way to it."""
        self._held.forget(self)

    def check(self, now: float) -> None:
        """Let the viewer look after itself."""
        self._viewer.check(now)

    def close(self) -> None:
        """End the viewer."""
        self.forget()
        self._viewer.close()


class HeldPictures:
    """The pictures under way to one client; on the loop's thread.

    Parameters
    ----------
    clock
        Sim time (s).

    Attributes
    ----------
    clock
        The same.
    """

    def __init__(self, line: Line, clock: Callable[[], float]) -> None:
        self.clock = clock
        self._pictures: PictureLine[EncodedPicture] = PictureLine(line)
        self._pump = LinePump(clock, self._release)

    @property
    def passes(self) -> bool:
        """Whether pictures arrive at once."""
        return self._pictures.passes

    def before(
        self,
        viewer: Viewer,
        *,
        rate: Optional[float] = None,
        takes: Callable[[], bool] = lambda: True,
    ) -> LateViewer:
        """Return a viewer that lets another one have its pictures late; see `LateViewer`."""
        return LateViewer(viewer, self, rate, takes)

    def send(self, viewer: LateViewer, picture: EncodedPicture) -> None:
        """Send a viewer a picture."""
        size = len(picture.data)
        self._pictures.offer(viewer, picture, size, picture.stamp, self.clock())
        self._pump.run()

    def forget(self, viewer: LateViewer) -> None:
        """Lose what is under way to a viewer that has gone."""
        self._pictures.forget(viewer)

    def close(self) -> None:
        """Let nothing arrive any more."""
        self._pump.close()

    def _release(self, now: float) -> Optional[float]:
        for viewer, picture in self._pictures.take(now):
            assert isinstance(viewer, LateViewer)
            viewer.arrive(picture)
        return self._pictures.next_due(now)
