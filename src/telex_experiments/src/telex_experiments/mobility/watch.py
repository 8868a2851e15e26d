"""Looks at every step of a trial: whether what has happened in it can have happened."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import List, Tuple

import numpy as np
import pybullet

from telex_sim.engine.world import GRAVITY

from .offline import OfflineTrial


@dataclass(frozen=True)
class WatchedMotion:
    """Of all bodies that move, the robot's links first, at one moment.

    Attributes
    ----------
    positions, velocities : ndarray, shape (n, 3)
        Of the centres of mass, in the world (m, m/s).
    orientations : ndarray, shape (n, 4)
        Of the principal axes (quaternion x, y, z, w).
    turning : ndarray, shape (n, 3)
        In the world (rad/s).
    """

    positions: np.ndarray
    orientations: np.ndarray
    velocities: np.ndarray
    turning: np.ndarray

    def finite(self) -> bool:
        """Whether all are numbers."""
        return all(bool(np.isfinite(values).all()) for values in vars(self).values())


class RunWatch:
    """Looks at every step of a trial.

    Attributes
    ----------
    finite : bool
        Whether every pose, velocity, joint position and joint velocity was a number.
    jump : float
        Farthest that a link came in a step beyond what its velocity explains (m).
    gain : float
        Most that the energy of all that moves has grown in a step (J).
    fastest : float
        Of all links (m/s).
    deepest : float
        Penetration of the robot into anything (m).
    cost : float
        CPU time that the looking itself took (s).
    """

    def __init__(self, trial: OfflineTrial) -> None:
        self._trial = trial
        self._bodies = _Bodies(trial)
        self.finite = True
        self.jump = self.gain = self.fastest = self.deepest = self.cost = 0.0
        self.restart()
        trial.each_step.append(self.look)

    def restart(self) -> None:
        """Take the present state for granted."""
        self._last = self._bodies.motion()
        self._energy = self._bodies.energy(self._last)

    def look(self) -> None:
        """Look at what the last step has done."""
        began = time.process_time()
        trial, last = self._trial, self._last
        motion = self._bodies.motion()
        self.finite = self.finite and motion.finite() and self._bodies.joints_finite()
        links = slice(self._bodies.links)
        explained = trial.step_size * motion.velocities[links]
        ways = motion.positions[links] - last.positions[links] - explained
        energy = self._bodies.energy(motion)
        self.jump = max(self.jump, float(np.linalg.norm(ways, axis=1).max()))
        self.gain = max(self.gain, energy - self._energy)
        self.fastest = max(
            self.fastest, float(np.linalg.norm(motion.velocities[links], axis=1).max())
        )
        self.deepest = max(self.deepest, trial.penetration())
        self._last, self._energy = motion, energy
        self.cost += time.process_time() - began


class _Bodies:
    """All that moves in a trial: the robot's links, then the links of what is loose."""

    def __init__(self, trial: OfflineTrial) -> None:
        body = trial.simulation.body
        self._client = body.client
        self._robot = body.uid
        self._joints: List[int] = list(body.joints.values())
        self._places: List[Tuple[int, List[int]]] = []
        masses, inertias = [], []
        others = [
            pybullet.getBodyUniqueId(index, physicsClientId=self._client)
            for index in range(pybullet.getNumBodies(physicsClientId=self._client))
        ]
        for uid in (body.uid, *(each for each in others if each != body.uid)):
            moving = []
            for index in range(-1, pybullet.getNumJoints(uid, physicsClientId=self._client)):
                dynamics = pybullet.getDynamicsInfo(uid, index, physicsClientId=self._client)
                if dynamics[0] > 0.0:
                    moving.append(index)
                    masses.append(dynamics[0])
                    inertias.append(dynamics[2])
            if moving:
                self._places.append((uid, moving))
        self.links = len(self._places[0][1])
        self._masses = np.array(masses)
        self._inertias = np.array(inertias)

    def motion(self) -> WatchedMotion:
        """How everything moves now."""
        client, rows = self._client, []
        for uid, indices in self._places:
            if indices[0] < 0:
                pose = pybullet.getBasePositionAndOrientation(uid, physicsClientId=client)
                velocity = pybullet.getBaseVelocity(uid, physicsClientId=client)
                rows.append((*pose[0], *pose[1], *velocity[0], *velocity[1]))
            links = [index for index in indices if index >= 0]
            if links:
                states = pybullet.getLinkStates(
                    uid,
                    links,
                    computeLinkVelocity=1,
                    computeForwardKinematics=1,
                    physicsClientId=client,
                )
                rows.extend((*s[0], *s[1], *s[6], *s[7]) for s in states)
        values = np.array(rows)
        return WatchedMotion(values[:, :3], values[:, 3:7], values[:, 7:10], values[:, 10:])

    def energy(self, motion: WatchedMotion) -> float:
        """Of motion and of height, together (J)."""
        vectors, scalars = motion.orientations[:, :3], motion.orientations[:, 3:]
        # The turning, in principal axes: rotated by the conjugate quaternion.
        aside = 2.0 * np.cross(motion.turning, vectors)
        turning = motion.turning + scalars * aside + np.cross(aside, vectors)
        own = self._masses * (
            0.5 * (motion.velocities**2).sum(axis=1) + GRAVITY * motion.positions[:, 2]
        )
        return float(own.sum() + 0.5 * (self._inertias * turning**2).sum())

    def joints_finite(self) -> bool:
        """Whether the robot's joints are at numbers."""
        states = pybullet.getJointStates(self._robot, self._joints, physicsClientId=self._client)
        return bool(np.isfinite([state[:2] for state in states]).all())
