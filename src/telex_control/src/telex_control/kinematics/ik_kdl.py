"""Backend of the inverse kinematics on PyKDL and numpy, for where there is no compiler.

The method is that of `ik_kernels`. An iteration costs about forty times as much, so restarts begin
at postures that are known to be near to the target.
"""

from __future__ import annotations

import math
from itertools import islice
from operator import itemgetter
from typing import Any, Dict, Iterable, Iterator, List, NamedTuple, Optional, Tuple

import numpy as np
import PyKDL

from telex_control.urdf.joints import PRISMATIC

from .chain import Chain, matrix
from .ik_options import IKOptions
from .ik_task import AT_LIMIT, DISTANCE, Backend, GoalFunction, Outcome, Task, Tick
from .pose_library import PARTS, ROUNDS, PoseLibrary, random_postures

_TURN = 2.0 * math.pi
_FLOOR = 1e-9
_KEEN = 1e-2
_TICK_GAIN = 1e-3
_NEAR = 1.0
"""Cost of a seed (weighted rad^2, halved) below which a solve begins there and nowhere else."""
_UNLIMITED_ITERATIONS = 12
_UNLIMITED_COST = 2
"""In iterations in the box, what so many without limits cost."""
Box = Tuple[np.ndarray, np.ndarray]


Vector = Tuple[float, float, float]


class _Target(NamedTuple):
    """A task, and its target as KDL has it, and as plain floats."""

    task: Task
    rotation: PyKDL.Rotation
    place: Vector
    quaternion: Tuple[float, float, float, float]

    @classmethod
    def of(cls, task: Task) -> _Target:
        rows = task.target.tolist()
        rotation = PyKDL.Rotation(*rows[0][:3], *rows[1][:3], *rows[2][:3])
        place = (rows[0][3], rows[1][3], rows[2][3])
        return cls(task, rotation, place, rotation.GetQuaternion())


class _Error(NamedTuple):
    """What is left to the target at a posture, beyond the bounds; in the base frame."""

    shift: Vector  # m
    turn: Vector  # rad
    active: Tuple[bool, ...]  # which components, in the target's frame, are beyond their bounds
    place_norm: float  # m
    turn_norm: float  # rad
    cost: float


_ALL = (True,) * 6
_triple = itemgetter(0, 1, 2)


class _Xorshift:
    """The generator of `ik_kernels`; made in no time, unlike the standard library's."""

    def __init__(self, seed: int) -> None:
        self._state = ((seed + 1) * 0x9E3779B97F4A7C15) % 2**64 or 1

    def random(self) -> float:
        """Return a number of [0, 1)."""
        x = self._state
        x ^= (x << 13) % 2**64
        x ^= x >> 7
        x ^= (x << 17) % 2**64
        self._state = x
        return (x >> 11) / 2**53


class KdlBackend(Backend):
    """Forward kinematics, Jacobian and damped least squares by KDL.

    Parameters
    ----------
    chain : Chain
    options : IKOptions
    box : pair of ndarray, shape (n,)
        Position limits, between which restarts begin.
    """

    name = "kdl"
    default_iterations = 500
    search_slice = 10

    def __init__(self, chain: Chain, options: IKOptions, box: Box) -> None:
        # KDL's solvers do not keep it alive.
        self._padded = padded = _padded(chain.kdl)
        self._count = len(chain.joints)
        self._box = box
        self._attempt = int(options.attempt_iterations)
        self._candidates = int(options.restart_candidates)
        self._prismatic = [joint.kind == PRISMATIC for joint in chain.joints]
        self._forward = PyKDL.ChainFkSolverPos_recursive(padded)
        self._to_jacobian = PyKDL.ChainJntToJacSolver(padded)
        self._step = PyKDL.ChainIkSolverVel_wdls(padded)
        # KDL damps where the least singular value is below this: everywhere.
        self._step.setEps(1e6)
        size = padded.getNrOfJoints()
        self._unlimited: Optional[PyKDL.ChainIkSolverPos_LMA] = None
        if size == self._count:
            weights = np.array([options.length_weight] * 3 + [1.0] * 3)
            tolerance = options.tolerance
            self._unlimited = PyKDL.ChainIkSolverPos_LMA(
                padded,
                weights,
                min(options.length_weight * tolerance.position, tolerance.rotation),
                _UNLIMITED_ITERATIONS,
            )
        self._here = PyKDL.JntArray(size)
        self._trial = PyKDL.JntArray(size)
        self._move = PyKDL.JntArray(size)
        self._frame = PyKDL.Frame()
        self._kdl_jacobian = PyKDL.Jacobian(size)
        self._all_free = np.diag([1.0] * self._count + [0.0] * (size - self._count))
        self._hold_weights: Dict[int, np.ndarray] = {}  # by the bits of the joints that are held
        self._held_key = -1
        self._hold(())
        self._joints = range(self._count)
        self._cells = [(row, column) for row in range(6) for column in self._joints]
        # What KDL's step has been told last.
        self._weight_squared = math.nan
        self._weighs_all = False
        self._library: Optional[PoseLibrary] = None
        self._seed = int(options.random_seed)

    def warm_up(self) -> None:
        """Make the library of poses."""
        self._known()

    def random(self, seed: int) -> Any:
        """See `Backend`."""
        return _Xorshift(seed)

    def forward(self, q: np.ndarray) -> np.ndarray:
        """See `Backend`."""
        _fill(self._here, q.tolist())
        self._forward.JntToCart(self._here, self._frame)
        return matrix(self._frame)

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        """See `Backend`."""
        _fill(self._here, q.tolist())
        return self._jacobian_at(self._here)

    def solve(
        self,
        task: Task,
        seed: np.ndarray,
        box: Box,
        random: Any,
        iterations: int,
        *,
        restart: bool = False,
    ) -> Outcome:
        """See `Backend`."""
        target = _Target.of(task)
        starts = self._starts(target, seed, box, random, restart=restart)
        best: Optional[Outcome] = None
        least, done = math.inf, 0
        for restarts, (start, is_near) in enumerate(starts, start=int(restart)):
            q = start
            if is_near and not task.bounded and self._unlimited is not None:
                q = self._without_limits(self._unlimited, target, start, box)
                done += _UNLIMITED_COST
            q = np.minimum(np.maximum(q, box[0]), box[1])
            found, error = self._descend(
                target, q, box, max(min(self._attempt, iterations - done), 0), 0.05, _FLOOR
            )
            done += max(found.iterations, 1)
            if best is None or found.converged or error.cost < least:
                best, least = found, error.cost
            if found.converged or done >= iterations:
                return best._replace(
                    q=self._unwind(best.q, seed, box), iterations=done, restarts=restarts
                )
        raise AssertionError("there is always another start")

    def descend(
        self, task: Task, q: np.ndarray, box: Box, iterations: int, damping: float = 0.0
    ) -> Outcome:
        """See `Backend`."""
        inside = np.minimum(np.maximum(q, box[0]), box[1])
        damping = max(damping, _FLOOR)
        return self._descend(_Target.of(task), inside, box, iterations, 1e-4, damping)[0]

    def slide(
        self, task: Task, q: np.ndarray, box: Box, goal: GoalFunction, rounds: int
    ) -> Tuple[np.ndarray, int]:
        """See `Backend`."""
        target = _Target.of(task)
        value = self.goal_value(task, q, goal)
        done = 0
        for _ in range(rounds):
            slope = self._slope(task, q, goal)
            done += 1 if goal.kind == DISTANCE else self._count
            line = self._projected(target, q, box, -slope)
            if line is None:
                break
            largest, fall = float(abs(line).max()), float(line @ slope)
            if largest < 1e-7 or fall >= 0.0:
                break
            length, probe = 0.5 / largest, 1e-3 / largest
            rise = self.goal_value(task, q + probe * line, goal) - value - probe * fall
            if rise > 0.0:
                length = min(length, -0.5 * fall * probe * probe / rise)
            moved, used = self._along(target, q, box, length * line, goal, value)
            done += used
            if moved is None:
                break
            gained = value - self.goal_value(task, moved, goal)
            q, value = moved, value - gained
            if gained < 1e-6 * (1.0 + abs(value)):
                break
        return q, done

    def _projected(
        self, target: _Target, q: np.ndarray, box: Box, wish: np.ndarray
    ) -> Optional[np.ndarray]:
        """Return the part of a move that leaves the task's error as it is."""
        _fill(self._here, q.tolist())
        active = self._error(target, self._here).active
        self._weigh(target.task, active)
        undone = -(self._jacobian_at(self._here) @ wish)
        into = target.task.target[:3, :3].T
        shift = into.T @ ((into @ undone[:3]) * active[:3])
        turn = into.T @ ((into @ undone[3:]) * active[3:])
        moved = self._box_step(
            (q + wish).tolist(),
            _triple(shift.tolist()),
            _triple(turn.tolist()),
            1e-6,
            box[0].tolist(),
            box[1].tolist(),
        )
        return None if moved is None else np.array(moved) - q

    def _along(
        self,
        target: _Target,
        q: np.ndarray,
        box: Box,
        line: np.ndarray,
        goal: GoalFunction,
        value: float,
    ) -> Tuple[Optional[np.ndarray], int]:
        """Return a solution on a line, or nearer, that meets the goal better than `value`."""
        done = 0
        for share in (1.0, 0.25, 0.0625, 0.015625):
            trial = np.minimum(np.maximum(q + share * line, box[0]), box[1])
            found, _ = self._descend(target, trial, box, 8, 0.05, _FLOOR)
            done += found.iterations + 1
            if found.converged and self.goal_value(target.task, found.q, goal) < value:
                return found.q, done
        return None, done

    def goal_value(self, task: Task, q: np.ndarray, goal: GoalFunction) -> float:
        """See `Backend`."""
        if goal.kind == DISTANCE:
            away = (q - goal.reference) / goal.scale
            return 0.5 * float(away @ away)
        values = np.linalg.svd(self._asked(task, q), compute_uv=False)
        return -float(np.log(np.maximum(values, 1e-12)).sum())

    def _slope(self, task: Task, q: np.ndarray, goal: GoalFunction) -> np.ndarray:
        """Gradient of a goal, by central differences where it has no simple form."""
        if goal.kind == DISTANCE:
            return (q - goal.reference) / goal.scale**2
        made = np.empty(self._count)
        for i in range(self._count):
            offset = np.zeros(self._count)
            offset[i] = 1e-5
            above = self.goal_value(task, q + offset, goal)
            made[i] = (above - self.goal_value(task, q - offset, goal)) / 2e-5
        return made

    def tick(
        self,
        task: Task,
        q: np.ndarray,
        limits: Box,
        reach: np.ndarray,
        iterations: int,
        damping: float = 0.0,
        *,
        measured: bool = True,
    ) -> Tick:
        """See `Backend`."""
        lower, upper = limits
        least, most = q - reach, q + reach
        box = (
            np.minimum(np.maximum(lower, least), most),
            np.maximum(np.minimum(upper, most), least),
        )
        target = _Target.of(task)
        inside = np.minimum(np.maximum(q, box[0]), box[1])
        outcome, error = self._descend(target, inside, box, iterations, 1e-4, max(damping, _FLOOR))
        q = outcome.q
        asked = self._asked(task, q)
        held = self._held(asked, target, error, q, box)
        held[((held > 0.0) & (q >= upper)) | ((held < 0.0) & (q <= lower))] *= AT_LIMIT
        if not measured:
            return Tick(outcome, held, 0.0, np.zeros(6))
        asked[:, abs(held) == AT_LIMIT] = 0.0
        left, values, _ = np.linalg.svd(asked, full_matrices=False)
        direction = np.zeros(6)
        direction[~np.isinf(task.bounds)] = left[:, -1]
        rotation = task.target[:3, :3]
        direction = np.concatenate([rotation @ direction[:3], rotation @ direction[3:]])
        return Tick(outcome, held, float(values[-1]), direction)

    # ---------------------------------------------------------------- at a posture

    def _jacobian_at(self, angles: PyKDL.JntArray) -> np.ndarray:
        made = self._kdl_jacobian
        self._to_jacobian.JntToJac(angles, made)
        flat = np.fromiter(map(made.__getitem__, self._cells), float, len(self._cells))
        return flat.reshape(6, self._count)

    def _error(self, target: _Target, angles: PyKDL.JntArray) -> _Error:
        task, frame = target.task, self._frame
        self._forward.JntToCart(angles, frame)
        there, here = target.place, frame.p
        x, y, z = there[0] - here[0], there[1] - here[1], there[2] - here[2]
        if task.free_axis >= 0:
            a, b, c = _swing(frame.M, target.rotation, task.free_axis)
        else:
            a, b, c = _turn(frame.M.GetQuaternion(), target.quaternion)
        active: Tuple[bool, ...] = _ALL
        if task.bounded:
            (x, y, z), (a, b, c), active = _beyond(target, (x, y, z), (a, b, c))
        far, turned = x * x + y * y + z * z, a * a + b * b + c * c
        return _Error(
            (x, y, z),
            (a, b, c),
            active,
            math.sqrt(far),
            math.sqrt(turned),
            0.5 * (task.length_weight**2 * far + turned),
        )

    def _asked(self, task: Task, q: np.ndarray) -> np.ndarray:
        """Weighted Jacobian along the target's axes, of the directions that a task asks for."""
        _fill(self._here, q.tolist())
        into = task.target[:3, :3].T
        made = self._jacobian_at(self._here)
        made[:3] = task.length_weight * (into @ made[:3])
        made[3:] = into @ made[3:]
        return made[~np.isinf(task.bounds)]

    def _held(
        self, asked: np.ndarray, target: _Target, error: _Error, q: np.ndarray, box: Box
    ) -> np.ndarray:
        """1 or -1 for joints at a side of the box that they would have to leave."""
        task = target.task
        into = task.target[:3, :3].T
        weighted = np.concatenate([task.length_weight * (into @ error.shift), into @ error.turn])
        weighted = weighted[~np.isinf(task.bounds)]
        slope = weighted @ asked
        noise = 1e-6 * np.linalg.norm(weighted) * np.linalg.norm(asked, axis=0)
        up = (slope > noise) & (q >= box[1])
        down = (slope < -noise) & (q <= box[0])
        return up.astype(float) - down.astype(float)

    # ---------------------------------------------------------------- descent

    def _descend(
        self,
        target: _Target,
        q: np.ndarray,
        box: Box,
        iterations: int,
        gain: float,
        damping: float,
    ) -> Tuple[Outcome, _Error]:
        """Levenberg-Marquardt in a box, as `ik_kernels` has it.

        On so few numbers, loops over plain floats are faster than numpy.
        """
        task = target.task
        values, lower, upper = q.tolist(), box[0].tolist(), box[1].tolist()
        _fill(self._here, values)
        error = self._error(target, self._here)
        active: Optional[Tuple[bool, ...]] = None
        mu, poor, done, converged = 1.0, 0, 0, True
        while not (error.place_norm <= task.position and error.turn_norm <= task.rotation):
            converged = False
            if done >= iterations or poor >= 3:
                break
            done += 1
            if error.active != active:
                active = error.active
                self._weigh(task, active)
            trial = self._box_step(
                values, error.shift, error.turn, mu * error.cost + damping, lower, upper
            )
            if trial is None or trial == values:
                break
            _fill(self._trial, trial)
            found = self._error(target, self._trial)
            if found.cost < error.cost:
                mu = max(0.25 * mu, 1e-6)
                poor = poor + 1 if found.cost > (1.0 - gain) * error.cost else 0
                values, error = trial, found
                self._here, self._trial = self._trial, self._here
            else:
                mu *= 8.0
                poor += gain > _KEEN
            converged = True
        outcome = Outcome(np.array(values), converged, error.place_norm, error.turn_norm, done, 0)
        return outcome, error

    def _weigh(self, task: Task, active: Tuple[bool, ...]) -> None:
        """Have KDL's step weigh lengths, and only what is beyond the bounds."""
        if active == _ALL and self._weighs_all and self._weight_squared == task.length_weight**2:
            return
        weights = np.diag([task.length_weight] * 3 + [1.0] * 3)
        self._weight_squared = task.length_weight**2
        self._weighs_all = active == _ALL
        if active != _ALL:
            rotation = task.target[:3, :3]
            for rows, part in ((slice(0, 3), active[:3]), (slice(3, 6), active[3:])):
                weights[rows, rows] = weights[rows, rows] @ (rotation * part) @ rotation.T
        self._step.setWeightTS(weights)

    def _box_step(
        self,
        values: List[float],
        shift: Vector,
        turn: Vector,
        damping: float,
        lower: List[float],
        upper: List[float],
    ) -> Optional[List[float]]:
        """Return values + move: least |J move - twist|^2 + damping |move|^2, in the box.

        J is that of `self._here`, the twist is shift and turn. Joints at a side of the box that
        the gradient pushes outwards are held. Those that the solution takes out of the box are put
        on its side, what they do is taken off the twist, and the rest is solved again. None when
        KDL finds no solution.
        """
        self._step.setLambda(math.sqrt(damping))
        jacobian = self._kdl_jacobian
        self._to_jacobian.JntToJac(self._here, jacobian)
        x, y, z, a, b, c = (*(self._weight_squared * value for value in shift), *turn)
        held: Dict[int, float] = {}
        for i in self._joints:
            if values[i] == lower[i] or values[i] == upper[i]:
                u = jacobian.getColumn(i)
                slope = u[0] * x + u[1] * y + u[2] * z + u[3] * a + u[4] * b + u[5] * c
                if values[i] == (upper[i] if slope > 0.0 else lower[i]):
                    held[i] = values[i]
        twist = PyKDL.Twist(PyKDL.Vector(*shift), PyKDL.Vector(*turn))
        while True:
            self._hold(held)
            if self._step.CartToJnt(self._here, twist, self._move) < 0:
                return None
            moves = map(self._move.__getitem__, self._joints)
            trial = [value + move for value, move in zip(values, moves)]
            for i, side in held.items():
                trial[i] = side
            left = [i for i in self._joints if not lower[i] <= trial[i] <= upper[i]]
            if not left:
                return trial
            for i in left:
                held[i] = lower[i] if trial[i] < lower[i] else upper[i]
                if held[i] != values[i]:
                    twist = twist - jacobian.getColumn(i) * (held[i] - values[i])

    def _hold(self, joints: Iterable[int]) -> None:
        """Have KDL's step leave some joints where they are."""
        key = sum(1 << i for i in joints)
        if key == self._held_key:
            return
        weights = self._hold_weights.get(key)
        if weights is None:
            weights = self._hold_weights[key] = self._all_free.copy()
            for i in joints:
                weights[i, i] = 0.0
        self._step.setWeightJS(weights)
        self._held_key = key

    # ---------------------------------------------------------------- restarts

    def _known(self) -> PoseLibrary:
        if self._library is None:
            postures = random_postures(self._box, self._seed)
            poses = np.empty((len(postures), 12))
            frame = PyKDL.Frame()
            for index, posture in enumerate(postures):
                _fill(self._here, posture.tolist())
                self._forward.JntToCart(self._here, frame)
                place, turn = frame.p, frame.M
                poses[index] = (*place, *(turn[row, k] for row in range(3) for k in range(3)))
            self._library = PoseLibrary(postures, poses)
        return self._library

    def _starts(
        self, target: _Target, seed: np.ndarray, box: Box, random: Any, *, restart: bool
    ) -> Iterator[Tuple[np.ndarray, bool]]:
        """Yield where to descend from: the seed, known postures, random ones without end.

        From afar a descent is long and mostly ends elsewhere; known postures come first there. The
        second of each pair: the posture is known to be near to the target.
        """
        if restart:
            # One of them a call: the calls of one search must not all begin alike.
            nearest = self._known().nearest(target.task, seed)
            yield next(islice(nearest, int(random.random() * PARTS * ROUNDS), None)), True
        else:
            is_close = self._cost(target, np.minimum(np.maximum(seed, box[0]), box[1])) < _NEAR
            if is_close:
                yield seed, False
            for posture in self._known().nearest(target.task, seed):
                yield posture, True
            if not is_close:
                yield seed, False
        while True:
            yield self._random_start(target, seed, box, random), False

    def _without_limits(
        self,
        unlimited: PyKDL.ChainIkSolverPos_LMA,
        target: _Target,
        start: np.ndarray,
        box: Box,
    ) -> np.ndarray:
        """Return where KDL's own Levenberg-Marquardt arrives, which knows no limits.

        An iteration costs a fifth of one in the box. On the short way from a posture near to the
        target it mostly stays inside; a descent in the box mends the rest.
        """
        _fill(self._here, start.tolist())
        goal = PyKDL.Frame(target.rotation, PyKDL.Vector(*target.place))
        unlimited.CartToJnt(self._here, goal, self._trial)
        found = [self._trial[i] for i in self._joints]
        if not math.isfinite(sum(found)):
            return start
        for i, (low, high) in enumerate(zip(box[0].tolist(), box[1].tolist())):
            if not low <= found[i] <= high and not self._prismatic[i]:
                found[i] -= _TURN * round((found[i] - 0.5 * (low + high)) / _TURN)
        return np.array(found)

    def _cost(self, target: _Target, posture: np.ndarray) -> float:
        _fill(self._here, posture.tolist())
        return self._error(target, self._here).cost

    def _random_start(self, target: _Target, seed: np.ndarray, box: Box, random: Any) -> np.ndarray:
        """Return that of some random postures whose pose is nearest to the target."""
        candidates: List[np.ndarray] = []
        for _ in range(self._candidates):
            made = np.empty(self._count)
            for i in range(self._count):
                low, high = box[0][i], box[1][i]
                if math.isinf(low) or math.isinf(high):
                    made[i] = seed[i] + (random.random() - 0.5) * _TURN
                else:
                    made[i] = low + random.random() * (high - low)
            candidates.append(made)
        return min(candidates, key=lambda posture: self._cost(target, posture))

    def _unwind(self, q: np.ndarray, seed: np.ndarray, box: Box) -> np.ndarray:
        """Take full turns off joints where that brings them nearer to the seed."""
        made = q.copy()
        for i in range(self._count):
            if self._prismatic[i]:
                continue
            turns = np.rint((seed[i] - q[i]) / _TURN)
            # As many as the limits leave room for; one less where rounding finds one too many.
            turns = min(turns, np.floor((box[1][i] - q[i]) / _TURN))
            turns = max(turns, np.ceil((box[0][i] - q[i]) / _TURN))
            moved = q[i] + turns * _TURN
            if not box[0][i] <= moved <= box[1][i]:
                moved = q[i] + (turns - math.copysign(1.0, turns)) * _TURN
            if turns != 0.0:
                made[i] = moved
        return made


def _padded(chain: PyKDL.Chain) -> PyKDL.Chain:
    """Return a chain with joints at its tip, to be kept at 0, so that there are six.

    KDL's damped least squares ends the process when there are fewer.
    """
    made = PyKDL.Chain(chain)
    while made.getNrOfJoints() < 6:
        made.addSegment(PyKDL.Segment(PyKDL.Joint(PyKDL.Joint.RotZ), PyKDL.Frame()))
    return made


def _fill(angles: PyKDL.JntArray, values: List[float]) -> None:
    for index, value in enumerate(values):
        angles[index] = value


def _beyond(
    target: _Target, shift: Vector, turn: Vector
) -> Tuple[Vector, Vector, Tuple[bool, ...]]:
    """Take the bounds of a task off an error; tell which components, in its frame, are left."""
    task, into = target.task, target.rotation.Inverse()
    along = *(into * PyKDL.Vector(*shift)), *(into * PyKDL.Vector(*turn))
    left: List[float] = []
    active: List[bool] = []
    for value, bound in zip(along, task.bounds.tolist()):
        beyond = abs(value) - bound
        left.append(math.copysign(beyond, value) if beyond > 0.0 else 0.0)
        active.append(beyond > 0.0 or bound == 0.0)
    if task.free_axis >= 0:
        active[3 + task.free_axis] = False
    back = target.rotation
    return (
        _triple(back * PyKDL.Vector(*left[:3])),
        _triple(back * PyKDL.Vector(*left[3:])),
        tuple(active),
    )


def _turn(
    here: Tuple[float, float, float, float], there: Tuple[float, float, float, float]
) -> Vector:
    """Rotation vector (base frame) from one quaternion x, y, z, w to another.

    Not PyKDL.diff, which takes angles below a millionth for none.
    """
    a, b, c, d = here
    e, f, g, h = there
    # there * conjugate of here
    x = e * d - h * a - f * c + g * b
    y = f * d - h * b - g * a + e * c
    z = g * d - h * c - e * b + f * a
    w = h * d + e * a + f * b + g * c
    sine = math.sqrt(x * x + y * y + z * z)
    if w < 0.0:
        w, sine = -w, -sine
    scale = 2.0 / w if abs(sine) < 1e-12 * w else 2.0 * math.atan2(abs(sine), w) / sine
    return scale * x, scale * y, scale * z


def _swing(rotation: PyKDL.Rotation, target: PyKDL.Rotation, axis: int) -> Vector:
    """Shortest rotation vector (base frame) that takes an axis of one rotation to the other's."""
    here, there = _axis(rotation, axis), _axis(target, axis)
    across = here * there
    sine = across.Norm()
    angle = math.atan2(sine, PyKDL.dot(here, there))
    if sine > 1e-12:
        return _triple(across * (angle / sine))
    # Opposite: any direction across is as short.
    return _triple(_axis(target, (axis + 1) % 3) * angle)


def _axis(rotation: PyKDL.Rotation, axis: int) -> PyKDL.Vector:
    return (rotation.UnitX, rotation.UnitY, rotation.UnitZ)[axis]()
