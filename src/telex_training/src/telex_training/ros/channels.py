"""Topics that are recorded, as they come: nothing is decoded on its way to the recording."""

from __future__ import annotations

from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple, Type, Union

import genpy
import rospy

from ..judging.activity import COMMANDS, STATUSES
from ..judging.entries import (
    ACTIONS,
    CLIENTS,
    DOSES,
    E_STOP,
    LIGHT,
    LINK,
    MALFUNCTIONS,
    NAMES,
    ODOMETRY,
    ODOMETRY_PERIOD,
    STATUS,
    TELEMETRY,
    TRUTH,
)
from ..judging.records.other_robot import channel_of

WATCHED: Dict[str, str] = {
    NAMES: "telex_msgs/TruthNames",
    TRUTH: "telex_msgs/TruthSample",
    STATUS: "telex_msgs/SimStatus",
    DOSES: "telex_msgs/ComponentDoses",
    LIGHT: "telex_msgs/SceneLight",
    CLIENTS: "telex_msgs/BridgeClients",
    ACTIONS: "telex_msgs/InstructorAction",
    TELEMETRY: "std_msgs/String",
    LINK: "telex_msgs/LinkState",
    E_STOP: "std_msgs/Bool",
    MALFUNCTIONS: "telex_msgs/Malfunctions",
    **COMMANDS,
    **STATUSES,
}
"""Topics in the robot's namespace that are always recorded, and their types."""
_STATE_PERIOD = 0.5
"""Sim time after which a state is recorded though it says nothing new but positions (s)."""
_BUFFER = 4 * 2**20
"""Bytes of a connection that are read at once: seconds of truth."""

Take = Callable[[str, str, bytes], None]
"""Takes channel, type and serialised message, in a thread of ROS."""


class StateChanges:
    """Picks what is worth recording of a teleoperation node's states, of which ten come a second.

    Parameters
    ----------
    kind : str
        Type of the messages.
    """

    def __init__(self, kind: str) -> None:
        self._class = genpy.message.get_message_class(kind)
        self._told: Tuple[Any, ...] = ()
        self._again_at = 0.0

    def tells(self, data: bytes, now: float) -> bool:
        """Whether a state says something new, or the last one was long ago.

        Parameters
        ----------
        data : bytes
            The serialised message.
        now : float
            Sim time (s).
        """
        try:
            message = self._class().deserialize(data)
        except genpy.DeserializationError:
            return True  # the judge says what is wrong with it
        says = tuple(
            str(getattr(message, name, ""))
            for name in ("mode", "active", "speed_scale", "limited", "message", "notice")
        )
        if says == self._told and self._again_at - _STATE_PERIOD <= now < self._again_at:
            return False
        self._told, self._again_at = says, now + _STATE_PERIOD
        return True


class Seldom:
    """Picks one message a while.

    Parameters
    ----------
    period : float
        Sim time from one to the next (s).
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self._again_at = 0.0

    def tells(self, data: bytes, now: float) -> bool:
        """Whether a message is due; see `StateChanges.tells`."""
        if self._again_at - self._period <= now < self._again_at:
            return False
        self._again_at = now + self._period
        return True


def hear_decoded(topic: str, kind: Type[Any], take: Callable[[Any], None]) -> rospy.Subscriber:
    """Listen to a topic that may be recorded as well.

    rospy decodes a topic for all of its listeners in a process or for none.

    Parameters
    ----------
    kind : type
        Of its messages.
    take : callable
        Takes a message, in a thread of ROS.
    """

    def hear(message: rospy.AnyMsg) -> None:
        made = kind()
        made.deserialize(message._buff)
        take(made)

    return rospy.Subscriber(topic, rospy.AnyMsg, hear, queue_size=None, tcp_nodelay=True)


class Channels:
    """Listens to what is recorded.

    Parameters
    ----------
    more : sequence of str
        Further topics that are recorded, such as lamps' and the zoom's.
    others : mapping of str to str, optional
        Namespaces of further robots, by the exercise's names: the same is recorded of them.
    station : sequence of str
        Namespaces of all further robots. Through the bridges of those that are none of the
        exercise's, instructors change the one scene as well: recorded as at the first robot's.
    """

    def __init__(
        self,
        take: Take,
        more: Sequence[str] = (),
        others: Optional[Mapping[str, str]] = None,
        station: Sequence[str] = (),
    ) -> None:
        # The names of the truth first, so that they are there when the first sample comes.
        self._subscribers: List[rospy.Subscriber] = [
            self._listen(channel, take, robot, namespace)
            for robot, namespace in (("", ""), *(others or {}).items())
            for channel in (*WATCHED, *more)
        ]
        self._subscribers += [
            self._listen(ACTIONS, take, "", namespace)
            for namespace in station
            if namespace not in (others or {}).values()
        ]

    def _listen(self, channel: str, take: Take, robot: str, namespace: str) -> rospy.Subscriber:
        recorded = channel_of(robot, channel)
        picked: Union[StateChanges, Seldom, None] = None
        if channel in STATUSES:
            picked = StateChanges(STATUSES[channel])
        elif channel == ODOMETRY:
            picked = Seldom(ODOMETRY_PERIOD)

        def hear(message: rospy.AnyMsg) -> None:
            if picked is None or picked.tells(message._buff, rospy.get_time()):
                take(recorded, message._connection_header["type"], message._buff)

        return rospy.Subscriber(
            f"{namespace}/{channel}" if namespace else channel,
            rospy.AnyMsg,
            hear,
            queue_size=None,
            buff_size=_BUFFER,
            tcp_nodelay=True,
        )

    def close(self) -> None:
        """Hear no more."""
        for subscriber in self._subscribers:
            subscriber.unregister()
