"""The topics ``sim/truth`` and ``sim/truth_names`` of one robot."""

from __future__ import annotations

import time as wall
from typing import Optional

import rospy
from telex_msgs.msg import TruthNames, TruthSample

from ..engine.simulation import Simulation
from ..robot.robot import Robot
from ..truth.messages import names_message, sample_message
from ..truth.sampler import SampledTruth, TruthSampler

_KEPT = 500
"""Samples that wait for a listener who is held up: 10 s."""


class TruthPublisher:
    """Publishes truth about a robot while somebody listens; in the simulation's thread."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._sampler: Optional[TruthSampler] = None
        self._sequence = 0
        self._revision = 0
        namespace = robot.namespace
        self._names = rospy.Publisher(
            f"{namespace}/sim/truth_names", TruthNames, queue_size=16, latch=True
        )
        self._samples = rospy.Publisher(
            f"{namespace}/sim/truth", TruthSample, queue_size=_KEPT, tcp_nodelay=True
        )

    @property
    def heard(self) -> bool:
        """Whether anybody listens."""
        return bool(self._samples.get_num_connections())

    def publish(
        self, simulation: Simulation, stamp: rospy.Time, resets: int, margin: float
    ) -> None:
        """Publish a sample, when anybody listens.

        Parameters
        ----------
        resets : int
            How often the scene was put back.
        margin : float
            Tip-over margin, 1 where none is known.
        """
        if not self.heard:
            # Samples that nobody hears are missing to who hears the next one, and are seen to be.
            self._sequence += 1
            if self._sampler is not None:
                self._sampler.close()
                self._sampler = None
            return
        if self._sampler is None:
            self._sampler = TruthSampler(simulation, self._robot)
            self._publish_names(self._sampler, stamp)
        elif self._sampler.refresh():
            self._publish_names(self._sampler, stamp)
        message = self._message(self._sampler.sample(), resets, margin)
        message.steps = simulation.steps
        message.header.stamp = stamp
        self._samples.publish(message)
        self._sequence += 1

    def _publish_names(self, sampler: TruthSampler, stamp: rospy.Time) -> None:
        self._revision += 1
        message = names_message(sampler.names, self._revision)
        message.header.stamp = stamp
        self._names.publish(message)

    def _message(self, sample: SampledTruth, resets: int, margin: float) -> TruthSample:
        message = sample_message(sample)
        message.sequence, message.revision = self._sequence, self._revision
        message.resets, message.margin = resets, margin
        message.wall_time = wall.time()
        return message

    def close(self) -> None:
        """Take the topics back."""
        if self._sampler is not None:
            self._sampler.close()
        self._samples.unregister()
        self._names.unregister()
