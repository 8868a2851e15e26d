"""Asks one station again and again, whatever the others do."""

from __future__ import annotations

import asyncio
import contextlib
import re
import time
from typing import Any, Callable, List, Mapping

from .answers import MOST_STANDING, BadAnswerError, Course, courses_of, state_of
from .station_client import StationClient, StationError
from .stations_file import ClassStation
from .watch import HERE, PICTURE_PERIOD, StationWatch

_FRONT = "front"
_CAMERA = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,60}")
_STANDING_TIMEOUT = 15.0
_ORDER_TIMEOUT = 60.0
"""Within which a station that closes an earlier recording opens an exercise (s)."""


class BusyError(RuntimeError):
    """A station has not answered to an earlier order yet."""


class StationPoller:
    """Watches one station; its methods are for the loop's thread.

    Parameters
    ----------
    pictures_wanted : callable
        Whether somebody looks at pictures.
    """

    def __init__(self, station: ClassStation, pictures_wanted: Callable[[], bool]) -> None:
        self.watch = StationWatch(station, time.monotonic())
        self._pictures_wanted = pictures_wanted
        self._client = StationClient(station)
        self._main_camera = ""
        self._orders: List[asyncio.Future[None]] = []

    @property
    def station(self) -> ClassStation:
        """The station, with the token that it was asked with last."""
        return self._client.station

    async def run(self) -> None:
        """Watch until cancelled."""
        async with self._client:
            try:
                await asyncio.gather(self._states(), self._pictures())
            finally:
                for order in self._orders:
                    order.cancel()

    async def _states(self) -> None:
        while True:
            try:
                state = state_of(await self._client.get("/training/api/state"))
            except Exception as error:  # whatever comes, the station is asked again
                self.watch.failed(time.monotonic(), str(error) or repr(error))
                self._main_camera = ""  # it may come back as another one
            else:
                self.watch.answered(time.monotonic(), state)
            await asyncio.sleep(self.watch.pause())

    async def _pictures(self) -> None:
        while True:
            if self._pictures_wanted() and self.watch.phase == HERE:
                # Why it does not answer is shown by what its state's question meets.
                with contextlib.suppress(Exception):
                    await self._picture()
            await asyncio.sleep(PICTURE_PERIOD)

    async def _picture(self) -> None:
        """Take a picture that is drawn for the trainee; without one, have a small one drawn."""
        camera = self.watch.camera(await self._find_main_camera())
        if not _CAMERA.fullmatch(camera):
            camera = _FRONT
        topic = f"cameras/{camera}"
        try:
            kind, data = await self._client.picture(f"{topic}/image_raw", True)
        except StationError as error:
            if error.status != 404 or not self.watch.may_have_drawn(time.monotonic()):
                return
            kind, data = await self._client.picture(f"{topic}/preview", False)
        self.watch.pictured(time.monotonic(), kind, data)

    async def _find_main_camera(self) -> str:
        if not self._main_camera:
            config = await self._client.get("/config.json")
            name = config.get("main_camera") if isinstance(config, dict) else None
            self._main_camera = name if isinstance(name, str) else _FRONT
        return self._main_camera

    async def courses(self) -> List[Course]:
        """Ask where people stand.

        Raises
        ------
        StationError
        """
        path = "/progress/api/standing"
        try:
            return courses_of(await self._client.get(path, MOST_STANDING, _STANDING_TIMEOUT))
        except BadAnswerError as error:
            raise StationError(f"{self.station.address}: {error}") from error

    def order(self, what: str, path: str, content: Mapping[str, Any]) -> None:
        """Have something done; what comes of it is shown with the station.

        Raises
        ------
        BusyError
        """
        order = self.watch.order
        if order is not None and not order["done"]:
            raise BusyError(f"{self.station.name}: it is still busy with: {order['what']}")
        self.watch.order = {"what": what, "done": False, "ok": False, "text": ""}
        self._orders = [each for each in self._orders if not each.done()]
        self._orders.append(asyncio.ensure_future(self._carry_out(what, path, content)))

    async def _carry_out(self, what: str, path: str, content: Mapping[str, Any]) -> None:
        try:
            await self._client.post(path, content, _ORDER_TIMEOUT)
            ok, text = True, "done"
        except StationError as error:
            ok, text = False, str(error)
        self.watch.order = {"what": what, "done": True, "ok": ok, "text": text}
