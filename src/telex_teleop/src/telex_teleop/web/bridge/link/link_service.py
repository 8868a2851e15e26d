"""The service `link/configure` and the topic `link/state`: what the line is, and who may say so."""

from __future__ import annotations

import asyncio
import contextlib
from typing import Any, Callable, Dict, Mapping, Optional, Protocol

import genpy
from telex_msgs.msg import LinkState, Radio, SimStatus
from telex_msgs.srv import ConfigureLink, ConfigureLinkRequest, ConfigureLinkResponse

from telex_control.common.params import ConfigError

from ...line.line import Line
from ...line.profiles import LineSetting, Profiles
from ...workers import OrderedWorker
from ..clients.control import Control
from ..protocol.compression import TopicMessage
from ..protocol.operations import OperationError
from ..ros import Ros
from ..topics.shared_topics import Publishers, SharedPublisher, SharedSubscriber, Subscribers

PERIOD = 0.1
"""Time (s) between two looks at whether an outage has begun or ended."""

LEAST_CHANGE = 0.01
"""Change of the signal's quality that the line follows."""

ANSWER_TIMEOUT = 5.0
"""Time (s) that a call waits for the loop."""


class Memory(Protocol):
    """Storage in which a setting survives a crash of the node."""

    def recall(self) -> Dict[str, Any]:
        """Return what was kept; nothing after an orderly end."""

    def keep(self, **values: Any) -> None:
        """Keep these values instead of those before."""

    def forget(self) -> None:
        """Delete what is kept."""


class _Listening:
    """One topic, listened to while that is wanted."""

    def __init__(
        self, subscribers: Subscribers, topic: str, kind: Any, take: Callable[[Any], None]
    ) -> None:
        self._subscribers = subscribers
        self._topic = topic
        self._kind = kind
        self._take = take
        self._subscriber: Optional[SharedSubscriber] = None

    async def want(self, wanted: bool) -> None:
        """Begin or end to listen."""
        if wanted and self._subscriber is None:
            with contextlib.suppress(OperationError, OSError):
                self._subscriber = await self._subscribers.join(self._topic, self._kind._type, self)
        elif not wanted and self._subscriber is not None:
            self._subscribers.leave(self._topic, self._subscriber, self)
            self._subscriber = None

    def deliver(self, message: TopicMessage) -> None:
        """Take a message."""
        self._take(message.message)


class LinkService:
    """Sets the line, follows the radio signal where the profile does, and tells what the line is.

    Commands under way are called back when the emergency stop is set, and when the scene is put
    back.

    Parameters
    ----------
    control
        Whose commands are called back.
    warn
        Called with what an administrator should know.
    memory
        Where the setting outlives a crash; None: it does not.
    """

    def __init__(
        self,
        line: Line,
        control: Control,
        profiles: Profiles,
        initial: LineSetting,
        *,
        ros: Ros,
        worker: OrderedWorker,
        publishers: Publishers,
        subscribers: Subscribers,
        warn: Callable[[str], None],
        memory: Optional[Memory] = None,
    ) -> None:
        self._line = line
        self._control = control
        self._profiles = profiles
        self._ros = ros
        self._worker = worker
        self._publishers = publishers
        self._warn = warn
        self._memory = memory
        self._changed = asyncio.Event()
        self._signal: Optional[float] = None
        self._status: Optional[SimStatus] = None
        self._radio_topic = _Listening(subscribers, ros.resolve("sim/radio"), Radio, self._hear)
        self._status_topic = _Listening(
            subscribers, ros.resolve("sim/status"), SimStatus, self._watch
        )
        self._setting = initial
        self._since = ros.sim_time()
        self._update()

    async def run(self) -> None:
        """Serve and publish until cancelled."""
        publisher = await self._publishers.acquire(
            self._ros.resolve("link/state"), LinkState._type, latch=True, queue_size=1
        )
        loop = asyncio.get_running_loop()
        serving = self._worker.submit(
            lambda: self._ros.serve(
                self._ros.resolve("link/configure"),
                ConfigureLink,
                lambda request: self._answer(request, loop),
            )
        )
        serving.add_done_callback(self._report_serving)
        told: Optional[LinkState] = None
        while True:
            self._changed.clear()
            # What was under way when the line became perfect can still be called back.
            impaired = not self._setting.is_perfect or self._control.has_under_way
            if not impaired:
                self._status = None
            await self._status_topic.want(impaired)
            await self._radio_topic.want(self._setting.by_signal is not None)
            told = self._tell(publisher, told)
            with contextlib.suppress(asyncio.TimeoutError):
                period = PERIOD if impaired else None
                await asyncio.wait_for(self._changed.wait(), period)

    def configure(self, setting: LineSetting) -> None:
        """Set the line, from now on."""
        self._setting = setting
        self._since = self._ros.sim_time()
        if setting.by_signal is None:
            self._signal = None
        if self._memory is not None:
            self._memory.keep(profile=setting.profile, fields=dict(setting.changes))
        self._update()

    def _update(self) -> None:
        self._line.configure(self._setting.at(self._signal), self._since)
        self._changed.set()

    def _answer(
        self, request: ConfigureLinkRequest, loop: asyncio.AbstractEventLoop
    ) -> ConfigureLinkResponse:
        """Answer a call, in a thread of rospy."""
        try:
            setting = self._profiles.choose(request.profile, request.fields)
        except ConfigError as error:
            return ConfigureLinkResponse(False, str(error))

        async def configure() -> None:
            self.configure(setting)

        try:
            asyncio.run_coroutine_threadsafe(configure(), loop).result(ANSWER_TIMEOUT)
        except Exception as error:  # the loop is busy, or has ended
            return ConfigureLinkResponse(False, f"the bridge does not get to it: {error!r}")
        return ConfigureLinkResponse(True, f"the line is {setting.described}")

    def _report_serving(self, serving: asyncio.Future[Any]) -> None:
        if not serving.cancelled() and serving.exception() is not None:
            self._warn(f"link/configure cannot be offered: {serving.exception()}")

    def _hear(self, radio: Radio) -> None:
        signal = min(max(radio.quality, 0.0), 1.0) if radio.quality == radio.quality else 0.0
        ends = signal in (0.0, 1.0) and signal != self._signal
        if self._signal is None or ends or abs(signal - self._signal) >= LEAST_CHANGE:
            self._signal = signal
            self._update()

    def _watch(self, status: SimStatus) -> None:
        before, self._status = self._status, status
        if before is None:
            return
        if status.resets != before.resets:
            self._control.call_back("the scene was put back")
        elif status.e_stop and not before.e_stop:
            self._control.call_back("the emergency stop was set")

    def _tell(self, publisher: SharedPublisher, told: Optional[LinkState]) -> LinkState:
        """Publish the line's state if it is another than was told last; return what is told."""
        now = self._ros.sim_time()
        state = link_state(self._setting, self._line, self._signal, self._since, now)
        if told is not None:
            state.header = told.header
            if state == told:
                return told
            state.header = type(told.header)(stamp=genpy.Time.from_sec(max(now, 0.0)))
        with contextlib.suppress(OperationError):  # the node is ending
            publisher.publish(state)
        return state


def link_state(
    setting: LineSetting, line: Line, signal: Optional[float], since: float, now: float
) -> LinkState:
    """Return the message that says what the line is at a sim time (s)."""
    state = LinkState(
        profile=setting.name,
        perfect=setting.is_perfect,
        since=genpy.Time.from_sec(max(since, 0.0)),
        outage=line.in_outage(now),
        signal_known=signal is not None,
        signal=0.0 if signal is None else signal,
        **vars(line.fields),
    )
    state.header.stamp = genpy.Time.from_sec(max(now, 0.0))
    return state


def initial_setting(
    profiles: Profiles, wanted: str, recalled: Mapping[str, Any], name: str
) -> LineSetting:
    """Return the line at the start of a node.

    Parameters
    ----------
    wanted
        Name of a profile, by the parameter.
    recalled
        What a node before this one has kept that has crashed.
    name
        Of the parameter, for messages.

    Raises
    ------
    telex_control.common.params.ConfigError
        There is no such profile.
    """
    if recalled:
        with contextlib.suppress(ConfigError, KeyError, TypeError):
            return profiles.combine(recalled["profile"], recalled["fields"])
    try:
        return profiles.combine(wanted, {})
    except ConfigError as error:
        raise ConfigError(f"parameter {name}: {error}") from None
