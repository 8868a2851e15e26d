"""The ROS sides of a PID loop: gains from parameters and at run time, and its state topic."""

from __future__ import annotations

from typing import Any, Dict, List

import genpy
from control_msgs.msg import PidState

from ..ros.node_handle import NodeHandle, Publisher, ReconfigurableParameter
from ..ros.sim_time import stamp
from .pid import Pid, PidGains

PARAMETERS = (
    ReconfigurableParameter("p", 10.0, -1e5, 1e5, "Proportional gain."),
    ReconfigurableParameter("i", 0.1, -1e5, 1e5, "Integral gain."),
    ReconfigurableParameter("d", 1.0, -1e3, 1e3, "Derivative gain."),
    ReconfigurableParameter("i_clamp_min", -10.0, -1e5, 0.0, "Least integral term."),
    ReconfigurableParameter("i_clamp_max", 10.0, 0.0, 1e5, "Largest integral term."),
    ReconfigurableParameter("antiwindup", False, False, True, "Bound the integral itself."),
)
"""Names, defaults and ranges are those of control_toolbox."""


class PidStatePublisher:
    """Publishes the inside of a PID loop, for tuning."""

    def __init__(self, pid: Pid, publisher: Publisher) -> None:
        self._pid = pid
        self._publisher = publisher

    def publish(self, time: float) -> None:
        """Publish the last sample of the loop, taken at `time` (s), when anybody listens."""
        if not self._publisher.has_subscribers():
            return
        pid = self._pid
        gains = pid.gains
        message = PidState()
        message.header.stamp = stamp(time)
        message.timestep = genpy.Duration.from_sec(pid.period)
        message.error, message.error_dot = pid.error, pid.error_dot
        message.p_error, message.i_error, message.d_error = pid.error, pid.integral, pid.error_dot
        message.p_term, message.i_term, message.d_term = gains.p, gains.i, gains.d
        message.i_max, message.i_min = gains.i_max, gains.i_min
        message.output = pid.output
        self._publisher.publish(message)


class PidSet:
    """The PID loops of one controller.

    Parameters
    ----------
    node : NodeHandle
        The controller's namespace.
    """

    def __init__(self, node: NodeHandle) -> None:
        self._node = node
        self._publishers: List[PidStatePublisher] = []

    def open(self, name: str) -> Pid:
        """Make the PID loop whose gains stand in the parameter `name`.

        They can be changed at run time by dynamic_reconfigure, in the same place. With
        ``publish_state: true``, the loop's inside is published on ``<name>/state``.

        Raises
        ------
        ConfigError
            A gain is missing or wrong.
        """
        node = self._node
        params = node.param(name, dict)
        pid = Pid(PidGains.from_params(params, node.resolve(name)))
        if params.get("publish_state", False):
            publisher = node.advertise(f"{name}/state", PidState, queue_size=1)
            self._publishers.append(PidStatePublisher(pid, publisher))

        def change(values: Dict[str, Any]) -> None:
            # One assignment: the loop sees either all old gains or all new ones.
            pid.gains = _gains(values)

        node.serve_reconfiguration(name, PARAMETERS, _values(pid.gains), change)
        return pid

    def publish(self, time: float) -> None:
        """Publish the state of the loops that have asked for it, sampled at `time` (s)."""
        for publisher in self._publishers:
            publisher.publish(time)


def _values(gains: PidGains) -> Dict[str, Any]:
    return {
        "p": gains.p,
        "i": gains.i,
        "d": gains.d,
        "i_clamp_min": gains.i_min,
        "i_clamp_max": gains.i_max,
        "antiwindup": gains.antiwindup,
    }


def _gains(values: Dict[str, Any]) -> PidGains:
    return PidGains(
        p=values["p"],
        i=values["i"],
        d=values["d"],
        i_max=values["i_clamp_max"],
        i_min=values["i_clamp_min"],
        antiwindup=values["antiwindup"],
    )
