"""Compiled numerics of the inverse kinematics: one chain, one thread, no allocation in the loop.

The method stands in docs/engineer/inverse_kinematics.md. Everything is computed in the target's
frame: the first constant of the chain is multiplied by the target's inverse once a call, after
which the target is the identity, and tolerances along its axes are those of single components.

All kernels stand in one file, because numba takes a cached kernel for fresh as long as its own file
is: a change of a callee elsewhere would go unnoticed.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Tuple

import numba
import numpy as np

from .compiled import Function, compiled
from .task import AT_LIMIT, DISTANCE, GoalFunction, Task

_TURN = 2.0 * math.pi
_FLOOR = 1e-9
"""Damping that is left at the target: keeps the factorisation defined in a singular posture."""
_TICK_GAIN = 1e-3
"""A descent that asks for less gain than this per step is that of a tick."""
_STIFF = 1e9
"""Damping beyond which no step is left to find."""


def _inner(function: Function) -> Function:
    """Compile what only kernels call: without the wrappers that calls from Python need."""
    return numba.njit(error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)(function)


class Model(NamedTuple):
    """A chain: what `telex_control.kinematics.inverse.joint_frames` returns."""

    links: np.ndarray
    prismatic: np.ndarray


class Work(NamedTuple):
    """Memory of a call, for n joints."""

    first: np.ndarray  # (3, 4) first constant of the chain, from the target's frame
    pose: np.ndarray  # (3, 4) of the tip in the target's frame
    axes: np.ndarray  # (n, 3) of the joints
    points: np.ndarray  # (n, 3) on these axes
    error: np.ndarray  # (6,) weighted, beyond the bounds
    trial_error: np.ndarray
    active: np.ndarray  # (6,) 1 where a component is beyond its bound, else 0
    trial_active: np.ndarray
    jacobian: np.ndarray  # (n, 6) transposed, weighted
    move: np.ndarray  # (n,)
    trial: np.ndarray  # (n,)
    free: np.ndarray  # (n,) not at a side of the box
    gradient: np.ndarray  # (n,)
    factor: np.ndarray  # (n, n) Cholesky factor
    pull: np.ndarray  # (n,) move that is wished for where the target leaves it open


@_inner
def _workspace(n: int) -> Work:
    # One piece of memory: to allocate each by itself would take as long as two iterations.
    memory = np.empty(48 + 16 * n + n * n)
    rest = memory[48:]
    return Work(
        memory[0:12].reshape(3, 4),
        memory[12:24].reshape(3, 4),
        rest[0 : 3 * n].reshape(n, 3),
        rest[3 * n : 6 * n].reshape(n, 3),
        memory[24:30],
        memory[30:36],
        memory[36:42],
        memory[42:48],
        rest[6 * n : 12 * n].reshape(n, 6),
        rest[12 * n : 13 * n],
        rest[13 * n : 14 * n],
        np.empty(n, np.bool_),
        rest[14 * n : 15 * n],
        rest[16 * n : 16 * n + n * n].reshape(n, n),
        rest[15 * n : 16 * n],
    )


@_inner
def _begin(model: Model, task: Task, work: Work) -> None:
    """Bring the chain into the frame of the target."""
    target, link, out = task.target, model.links[0], work.first
    for i in range(work.pull.size):
        work.pull[i] = 0.0
    for row in range(3):
        for column in range(4):
            total = 0.0
            for k in range(3):
                entry = link[k, column]
                if column == 3:
                    entry -= target[k, 3]
                total += target[k, row] * entry
            out[row, column] = total


@_inner
def _forward(model: Model, q: np.ndarray, work: Work) -> None:
    """Fill pose, axes and points of `work`."""
    first, axes, points = work.first, work.axes, work.points
    r00, r01, r02, px = first[0, 0], first[0, 1], first[0, 2], first[0, 3]
    r10, r11, r12, py = first[1, 0], first[1, 1], first[1, 2], first[1, 3]
    r20, r21, r22, pz = first[2, 0], first[2, 1], first[2, 2], first[2, 3]
    for i in range(q.size):
        axes[i, 0], axes[i, 1], axes[i, 2] = r02, r12, r22
        points[i, 0], points[i, 1], points[i, 2] = px, py, pz
        if model.prismatic[i]:
            px += r02 * q[i]
            py += r12 * q[i]
            pz += r22 * q[i]
        else:
            c, s = math.cos(q[i]), math.sin(q[i])
            r00, r01 = r00 * c + r01 * s, r01 * c - r00 * s
            r10, r11 = r10 * c + r11 * s, r11 * c - r10 * s
            r20, r21 = r20 * c + r21 * s, r21 * c - r20 * s
        link = model.links[i + 1]
        a, b, c = link[0, 3], link[1, 3], link[2, 3]
        px += r00 * a + r01 * b + r02 * c
        py += r10 * a + r11 * b + r12 * c
        pz += r20 * a + r21 * b + r22 * c
        m00, m01, m02 = link[0, 0], link[0, 1], link[0, 2]
        m10, m11, m12 = link[1, 0], link[1, 1], link[1, 2]
        m20, m21, m22 = link[2, 0], link[2, 1], link[2, 2]
        a = r00 * m00 + r01 * m10 + r02 * m20
        b = r00 * m01 + r01 * m11 + r02 * m21
        r02 = r00 * m02 + r01 * m12 + r02 * m22
        r00, r01 = a, b
        a = r10 * m00 + r11 * m10 + r12 * m20
        b = r10 * m01 + r11 * m11 + r12 * m21
        r12 = r10 * m02 + r11 * m12 + r12 * m22
        r10, r11 = a, b
        a = r20 * m00 + r21 * m10 + r22 * m20
        b = r20 * m01 + r21 * m11 + r22 * m21
        r22 = r20 * m02 + r21 * m12 + r22 * m22
        r20, r21 = a, b
    pose = work.pose
    pose[0, 0], pose[0, 1], pose[0, 2], pose[0, 3] = r00, r01, r02, px
    pose[1, 0], pose[1, 1], pose[1, 2], pose[1, 3] = r10, r11, r12, py
    pose[2, 0], pose[2, 1], pose[2, 2], pose[2, 3] = r20, r21, r22, pz


@_inner
def _turn_back(pose: np.ndarray, error: np.ndarray) -> None:
    """error[3:6] = rotation vector that takes the pose's rotation to the identity.

    Through the quaternion, divided by its largest component (S. W. Shepperd 1978): exact for small
    angles, and defined at half a turn.
    """
    trace = pose[0, 0] + pose[1, 1] + pose[2, 2]
    if trace > 0.0:
        w = 1.0 + trace
        x = pose[2, 1] - pose[1, 2]
        y = pose[0, 2] - pose[2, 0]
        z = pose[1, 0] - pose[0, 1]
    elif pose[0, 0] >= pose[1, 1] and pose[0, 0] >= pose[2, 2]:
        x = 1.0 + 2.0 * pose[0, 0] - trace
        y = pose[0, 1] + pose[1, 0]
        z = pose[0, 2] + pose[2, 0]
        w = pose[2, 1] - pose[1, 2]
    elif pose[1, 1] >= pose[2, 2]:
        x = pose[0, 1] + pose[1, 0]
        y = 1.0 + 2.0 * pose[1, 1] - trace
        z = pose[1, 2] + pose[2, 1]
        w = pose[0, 2] - pose[2, 0]
    else:
        x = pose[0, 2] + pose[2, 0]
        y = pose[1, 2] + pose[2, 1]
        z = 1.0 + 2.0 * pose[2, 2] - trace
        w = pose[1, 0] - pose[0, 1]
    sine = math.sqrt(x * x + y * y + z * z)
    if w < 0.0:
        w, sine = -w, -sine
    # For no rotation, the limit of angle / sine.
    scale = -2.0 / w if abs(sine) < 1e-12 * w else -2.0 * math.atan2(abs(sine), w) / sine
    error[3], error[4], error[5] = scale * x, scale * y, scale * z


@_inner
def _swing_back(pose: np.ndarray, axis: int, error: np.ndarray) -> None:
    """error[3:6] = shortest rotation vector that takes the pose's axis to the target's."""
    j, k = (axis + 1) % 3, (axis + 2) % 3
    along, side, other = pose[axis, axis], pose[j, axis], pose[k, axis]
    sine = math.hypot(side, other)
    angle = math.atan2(sine, along)
    error[3 + axis] = 0.0
    if sine > 1e-12:
        error[3 + j] = angle * other / sine
        error[3 + k] = -angle * side / sine
    else:
        # Opposite: any direction is as short.
        error[3 + j], error[3 + k] = angle, 0.0


@_inner
def _residual(
    task: Task, pose: np.ndarray, error: np.ndarray, active: np.ndarray
) -> Tuple[float, float]:
    """Fill error and active; return the norms of position and orientation error (m, rad)."""
    error[0], error[1], error[2] = -pose[0, 3], -pose[1, 3], -pose[2, 3]
    if task.free_axis >= 0:
        _swing_back(pose, task.free_axis, error)
    else:
        _turn_back(pose, error)
    if task.bounded:
        for i in range(6):
            beyond = abs(error[i]) - task.bounds[i]
            active[i] = 1.0 if beyond > 0.0 or task.bounds[i] == 0.0 else 0.0
            error[i] = math.copysign(beyond, error[i]) if beyond > 0.0 else 0.0
        if task.free_axis >= 0:
            active[3 + task.free_axis] = 0.0
    place = math.sqrt(error[0] * error[0] + error[1] * error[1] + error[2] * error[2])
    turn = math.sqrt(error[3] * error[3] + error[4] * error[4] + error[5] * error[5])
    for i in range(3):
        error[i] *= task.length_weight
    return place, turn


@_inner
def _cost(task: Task, place: float, turn: float) -> float:
    weighted = task.length_weight * place
    return 0.5 * (weighted * weighted + turn * turn)


@_inner
def _jacobian(model: Model, task: Task, active: np.ndarray, work: Work) -> None:
    """Fill the Jacobian of `work` from its axes, points and pose."""
    weight, jacobian, pose = task.length_weight, work.jacobian, work.pose
    for i in range(jacobian.shape[0]):
        a, b, c = work.axes[i, 0], work.axes[i, 1], work.axes[i, 2]
        column = jacobian[i]
        if model.prismatic[i]:
            column[0], column[1], column[2] = weight * a, weight * b, weight * c
            column[3], column[4], column[5] = 0.0, 0.0, 0.0
        else:
            x = pose[0, 3] - work.points[i, 0]
            y = pose[1, 3] - work.points[i, 1]
            z = pose[2, 3] - work.points[i, 2]
            column[0] = weight * (b * z - c * y)
            column[1] = weight * (c * x - a * z)
            column[2] = weight * (a * y - b * x)
            column[3], column[4], column[5] = a, b, c
        if task.bounded:
            for k in range(6):
                column[k] *= active[k]


@_inner
def _dot6(a: np.ndarray, b: np.ndarray) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5]


@_inner
def _box_step(
    error: np.ndarray,
    damping: float,
    q: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    work: Work,
) -> None:
    """work.move = argmin |J move - error|^2 + damping |move - pull|^2 with q + move in the box.

    Joints at a side of the box that would leave it are held. Those that the solution takes out of
    it are put on the side, what they do is taken off the error, and the rest is solved again.
    """
    n = q.size
    jacobian, move, free = work.jacobian, work.move, work.free
    gradient, factor, pull = work.gradient, work.factor, work.pull
    for i in range(n):
        move[i] = 0.0
        slope = _dot6(jacobian[i], error) + damping * pull[i]
        free[i] = not ((slope < 0.0 and q[i] <= lower[i]) or (slope > 0.0 and q[i] >= upper[i]))
    for _ in range(n + 1):
        e0, e1, e2, e3, e4, e5 = error[0], error[1], error[2], error[3], error[4], error[5]
        for i in range(n):
            if not free[i] and move[i] != 0.0:
                column, d = jacobian[i], move[i]
                e0 -= column[0] * d
                e1 -= column[1] * d
                e2 -= column[2] * d
                e3 -= column[3] * d
                e4 -= column[4] * d
                e5 -= column[5] * d
        for i in range(n):
            if free[i]:
                c = jacobian[i]
                gradient[i] = (
                    c[0] * e0 + c[1] * e1 + c[2] * e2 + c[3] * e3 + c[4] * e4 + c[5] * e5
                ) + damping * pull[i]
                for j in range(i + 1):
                    if free[j]:
                        total = _dot6(c, jacobian[j])
                        for k in range(j):
                            if free[k]:
                                total -= factor[i, k] * factor[j, k]
                        if i == j:
                            # Rounding must not make the pivot less than the damping leaves it.
                            factor[i, i] = math.sqrt(max(total + damping, damping))
                        else:
                            factor[i, j] = total / factor[j, j]
        for i in range(n):
            if free[i]:
                total = gradient[i]
                for k in range(i):
                    if free[k]:
                        total -= factor[i, k] * move[k]
                move[i] = total / factor[i, i]
        for i in range(n - 1, -1, -1):
            if free[i]:
                total = move[i]
                for k in range(i + 1, n):
                    if free[k]:
                        total -= factor[k, i] * move[k]
                move[i] = total / factor[i, i]
        left = False
        for i in range(n):
            if free[i]:
                if q[i] + move[i] < lower[i]:
                    move[i] = lower[i] - q[i]
                    free[i], left = False, True
                elif q[i] + move[i] > upper[i]:
                    move[i] = upper[i] - q[i]
                    free[i], left = False, True
        if not left:
            break


@_inner
def _moved(q: np.ndarray, lower: np.ndarray, upper: np.ndarray, work: Work) -> float:
    """work.trial = q + move, in the box in spite of rounding; returns the largest move."""
    largest = 0.0
    for i in range(q.size):
        work.trial[i] = min(max(q[i] + work.move[i], lower[i]), upper[i])
        largest = max(largest, abs(work.trial[i] - q[i]))
    return largest


@_inner
def _descend(
    model: Model,
    task: Task,
    q: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    iterations: int,
    gain: float,
    damping: float,
    work: Work,
) -> Tuple[bool, float, float, int]:
    """Levenberg-Marquardt in a box, from `q` on, in place.

    Ends at the target, after `iterations`, after three steps in a row that lessen the cost by less
    than the part `gain`, or when the step vanishes. Steps that are refused count among the three
    only with a `gain` above `_TICK_GAIN`, where beginning elsewhere is the better use of time, or
    with damping beyond `_STIFF`. Steps are damped by `damping` and by what is left of the cost.

    Returns converged, position error (m), orientation error (rad), iterations; `work.jacobian` and
    `work.error` are those of the last `q`.
    """
    error, trial_error = work.error, work.trial_error
    active, trial_active = work.active, work.trial_active
    _forward(model, q, work)
    place, turn = _residual(task, work.pose, error, active)
    _jacobian(model, task, active, work)
    cost = _cost(task, place, turn)
    mu, poor, done = 1.0, 0, 0
    while not (place <= task.position and turn <= task.rotation):
        if done >= iterations or poor >= 3:
            return False, place, turn, done
        done += 1
        _box_step(error, mu * cost + damping, q, lower, upper, work)
        if _moved(q, lower, upper, work) < 1e-13:
            return False, place, turn, done
        _forward(model, work.trial, work)
        trial_place, trial_turn = _residual(task, work.pose, trial_error, trial_active)
        trial_cost = _cost(task, trial_place, trial_turn)
        if trial_cost < cost:
            mu = max(0.25 * mu, 1e-6)
            poor = poor + 1 if trial_cost > (1.0 - gain) * cost else 0
            place, turn, cost = trial_place, trial_turn, trial_cost
            for i in range(q.size):
                q[i] = work.trial[i]
            for i in range(6):
                error[i], active[i] = trial_error[i], trial_active[i]
            _jacobian(model, task, active, work)
        else:
            mu *= 8.0
            # A tick's box is far smaller than the way to the target: what the box step takes for
            # its best may raise the cost there. Damping finds the way down; giving up would freeze.
            if gain > _TICK_GAIN or mu > _STIFF:
                poor += 1
    return True, place, turn, done


@_inner
def _uniform(state: np.ndarray) -> float:
    """Next number of [0, 1) of G. Marsaglia's xorshift generator, J. Statistical Software 8."""
    x = state[0]
    x ^= x << np.uint64(13)
    x ^= x >> np.uint64(7)
    x ^= x << np.uint64(17)
    state[0] = x
    return float(x >> np.uint64(11)) * (1.0 / 9007199254740992.0)


@_inner
def _restart(
    model: Model,
    task: Task,
    seed: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    candidates: int,
    state: np.ndarray,
    q: np.ndarray,
    work: Work,
) -> None:
    """Fill q with that of some random postures in the box whose pose is nearest to the target."""
    best = math.inf
    for _ in range(candidates):
        for i in range(q.size):
            if math.isinf(lower[i]) or math.isinf(upper[i]):
                work.trial[i] = seed[i] + (_uniform(state) - 0.5) * _TURN
            else:
                work.trial[i] = lower[i] + _uniform(state) * (upper[i] - lower[i])
        _forward(model, work.trial, work)
        place, turn = _residual(task, work.pose, work.trial_error, work.trial_active)
        cost = _cost(task, place, turn)
        if cost < best:
            best = cost
            for i in range(q.size):
                q[i] = work.trial[i]


@_inner
def _unwind(
    model: Model, seed: np.ndarray, lower: np.ndarray, upper: np.ndarray, q: np.ndarray
) -> None:
    """Take full turns off joints where that brings them nearer to the seed."""
    for i in range(q.size):
        if model.prismatic[i]:
            continue
        turns = np.rint((seed[i] - q[i]) / _TURN)
        # As many as the limits leave room for; one less where rounding finds one too many.
        turns = min(turns, np.floor((upper[i] - q[i]) / _TURN))
        turns = max(turns, np.ceil((lower[i] - q[i]) / _TURN))
        moved = q[i] + turns * _TURN
        if not lower[i] <= moved <= upper[i]:
            moved = q[i] + (turns - math.copysign(1.0, turns)) * _TURN
        if turns != 0.0:
            q[i] = moved


@compiled
def solve(
    model: Model,
    task: Task,
    seed: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    state: np.ndarray,
    iterations: int,
    attempt: int,
    candidates: int,
    restart: bool,
    out: np.ndarray,
) -> Tuple[bool, float, float, int, int]:
    """Descend with restarts; `out` gets the best q.

    Returns converged, position error (m), orientation error (rad), iterations, restarts.
    """
    work = _workspace(seed.size)
    q = np.empty(seed.size)
    _begin(model, task, work)
    best, best_place, best_turn = math.inf, math.inf, math.inf
    done, restarts = 0, 0
    while True:
        if restart or done > 0:
            restarts += 1
            _restart(model, task, seed, lower, upper, candidates, state, q, work)
        else:
            for i in range(q.size):
                q[i] = min(max(seed[i], lower[i]), upper[i])
        converged, place, turn, used = _descend(
            model, task, q, lower, upper, min(attempt, iterations - done), 0.05, _FLOOR, work
        )
        # At least one: an attempt that cannot move must not go on for ever.
        done += max(used, 1)
        cost = _cost(task, place, turn)
        if converged or cost < best:
            best, best_place, best_turn = cost, place, turn
            for i in range(q.size):
                out[i] = q[i]
        if converged or done >= iterations:
            _unwind(model, seed, lower, upper, out)
            return converged, best_place, best_turn, done, restarts


@_inner
def _push(
    work: Work, q: np.ndarray, lower: np.ndarray, upper: np.ndarray, pushed: np.ndarray
) -> None:
    """Fill which joints stand at a side of the box that they would have to leave."""
    length = math.sqrt(_dot6(work.error, work.error))
    for i in range(q.size):
        column = work.jacobian[i]
        slope = _dot6(column, work.error)
        noise = 1e-6 * length * math.sqrt(_dot6(column, column))
        pushed[i] = 0.0
        if slope > noise and q[i] >= upper[i]:
            pushed[i] = 1.0
        elif slope < -noise and q[i] <= lower[i]:
            pushed[i] = -1.0


@compiled
def descend(
    model: Model,
    task: Task,
    lower: np.ndarray,
    upper: np.ndarray,
    iterations: int,
    damping: float,
    q: np.ndarray,
) -> Tuple[bool, float, float, int]:
    """Descend from `q` in place to the next minimum in the box; see `Backend.descend`."""
    work = _workspace(q.size)
    _begin(model, task, work)
    for i in range(q.size):
        q[i] = min(max(q[i], lower[i]), upper[i])
    damping = max(damping, _FLOOR)
    return _descend(model, task, q, lower, upper, iterations, 1e-4, damping, work)


@_inner
def _gram(model: Model, task: Task, work: Work, gram: np.ndarray) -> None:
    """Fill J J^T of the rows that the task asks for, or J^T J where the joints are fewer.

    Needs axes, points and pose in `work`. Rows and columns beyond the last are those of the
    identity, scaled to be above all others.
    """
    n = work.jacobian.shape[0]
    for k in range(6):
        work.active[k] = 0.0 if math.isinf(task.bounds[k]) else 1.0
    _jacobian(model, task, work.active, work)
    rows = 0
    for k in range(6):
        if work.active[k] > 0.0:
            for i in range(n):
                work.jacobian[i, rows] = work.jacobian[i, k]
            rows += 1
    total = 0.0
    size = min(rows, n)
    for a in range(size):
        for b in range(a + 1):
            entry = 0.0
            if rows <= n:
                for i in range(n):
                    entry += work.jacobian[i, a] * work.jacobian[i, b]
            else:
                for k in range(rows):
                    entry += work.jacobian[a, k] * work.jacobian[b, k]
            gram[a, b] = gram[b, a] = entry
        total += gram[a, a]
    for a in range(6):
        for b in range(6):
            if a >= size or b >= size:
                gram[a, b] = total if a == b else 0.0


@_inner
def _goal(
    model: Model, task: Task, goal: GoalFunction, q: np.ndarray, work: Work, gram: np.ndarray
) -> float:
    """Value of a goal. `work.trial` may be `q`; jacobian, pose and active of `work` are spoilt."""
    value = 0.0
    if goal.kind == DISTANCE:
        for i in range(q.size):
            away = (q[i] - goal.reference[i]) / goal.scale[i]
            value += 0.5 * away * away
        return value
    _forward(model, q, work)
    _gram(model, task, work, gram)
    rows = 0
    for k in range(6):
        if not math.isinf(task.bounds[k]):
            rows += 1
    # Minus log of Yoshikawa's measure, by Cholesky's factorisation in place.
    for a in range(min(rows, q.size)):
        for b in range(a + 1):
            entry = gram[a, b]
            for k in range(b):
                entry -= gram[a, k] * gram[b, k]
            if a == b:
                gram[a, a] = math.sqrt(max(entry, 1e-24))
            else:
                gram[a, b] = entry / gram[b, b]
        value -= math.log(gram[a, a])
    return value


@compiled
def goal_value(model: Model, task: Task, goal: GoalFunction, q: np.ndarray) -> float:
    """Value of a goal."""
    work = _workspace(q.size)
    _begin(model, task, work)
    return _goal(model, task, goal, q, work, np.empty((6, 6)))


@_inner
def _slope(
    model: Model,
    task: Task,
    goal: GoalFunction,
    q: np.ndarray,
    work: Work,
    gram: np.ndarray,
    slope: np.ndarray,
) -> None:
    """Fill the gradient of a goal, by central differences where it has no simple form."""
    for i in range(q.size):
        if goal.kind == DISTANCE:
            slope[i] = (q[i] - goal.reference[i]) / (goal.scale[i] * goal.scale[i])
        else:
            here = q[i]
            q[i] = here + 1e-5
            above = _goal(model, task, goal, q, work, gram)
            q[i] = here - 1e-5
            below = _goal(model, task, goal, q, work, gram)
            q[i] = here
            slope[i] = (above - below) / 2e-5


@compiled
def slide(
    model: Model,
    task: Task,
    goal: GoalFunction,
    lower: np.ndarray,
    upper: np.ndarray,
    rounds: int,
    q: np.ndarray,
) -> int:
    """Lessen a goal where the target leaves the joints open, in place; returns the iterations.

    Each round goes down the goal's gradient projected into what the target leaves open, as far as
    a parabola through the goal along this line says, and back onto the target.
    """
    n = q.size
    work = _workspace(n)
    gram = np.empty((6, 6))
    slope, line, moved = np.empty(n), np.empty(n), np.empty(n)
    _begin(model, task, work)
    value = _goal(model, task, goal, q, work, gram)
    share, done, stale, length = 1.0, 0, True, 0.0
    for _ in range(rounds):
        if stale:
            _slope(model, task, goal, q, work, gram, slope)
            done += 1 if goal.kind == DISTANCE else n
            for i in range(n):
                work.pull[i] = -slope[i]
            _forward(model, q, work)
            _residual(task, work.pose, work.error, work.active)
            _jacobian(model, task, work.active, work)
            for i in range(6):
                work.error[i] = 0.0
            _box_step(work.error, 1e-6, q, lower, upper, work)
            largest, fall = 0.0, 0.0
            for i in range(n):
                work.pull[i] = 0.0
                line[i] = work.move[i]
                largest = max(largest, abs(line[i]))
                fall += line[i] * slope[i]
            if largest < 1e-7 or fall >= 0.0:
                return done
            # To half a radian or metre for a joint, or to the foot of the parabola before.
            length, probe = 0.5 / largest, 1e-3 / largest
            for i in range(n):
                moved[i] = q[i] + probe * line[i]
            rise = _goal(model, task, goal, moved, work, gram) - value - probe * fall
            if rise > 0.0:
                length = min(length, -0.5 * fall * probe * probe / rise)
        for i in range(n):
            work.move[i] = share * length * line[i]
        _moved(q, lower, upper, work)
        for i in range(n):
            moved[i] = work.trial[i]
        converged, _place, _turn, used = _descend(
            model, task, moved, lower, upper, 8, 0.05, _FLOOR, work
        )
        done += used + 1
        trial_value = _goal(model, task, goal, moved, work, gram)
        stale = converged and trial_value < value
        if stale:
            gained = value - trial_value
            value = trial_value
            for i in range(n):
                q[i] = moved[i]
            share = 1.0
            if gained < 1e-6 * (1.0 + abs(value)):
                return done
        else:
            share *= 0.25
            if share < 1e-2:
                return done
    return done


@_inner
def _condition(
    model: Model, task: Task, held: np.ndarray, direction: np.ndarray, work: Work
) -> float:
    """Smallest singular value of the task's Jacobian; fills its twist in the base frame.

    Joints that a position limit holds are left out. Needs axes, points and pose in `work`. By
    C. G. J. Jacobi's rotations of the Gram matrix, which find small eigenvalues accurately.
    """
    n = held.size
    for i in range(n):
        if abs(held[i]) == AT_LIMIT:
            # Neither turns nor shifts the tip.
            work.axes[i, 0] = work.axes[i, 1] = work.axes[i, 2] = 0.0
    gram = np.empty((6, 6))
    _gram(model, task, work, gram)
    vectors = np.eye(6)
    for _ in range(12):
        off = 0.0
        for a in range(5):
            for b in range(a + 1, 6):
                off += gram[a, b] * gram[a, b]
        if off < 1e-30 * gram[0, 0] * gram[0, 0]:
            break
        for a in range(5):
            for b in range(a + 1, 6):
                if gram[a, b] == 0.0:
                    continue
                half = 0.5 * (gram[b, b] - gram[a, a]) / gram[a, b]
                t = math.copysign(1.0, half) / (abs(half) + math.sqrt(half * half + 1.0))
                c = 1.0 / math.sqrt(t * t + 1.0)
                s = t * c
                for k in range(6):
                    x, y = gram[k, a], gram[k, b]
                    gram[k, a], gram[k, b] = c * x - s * y, s * x + c * y
                for k in range(6):
                    x, y = gram[a, k], gram[b, k]
                    gram[a, k], gram[b, k] = c * x - s * y, s * x + c * y
                for k in range(6):
                    x, y = vectors[k, a], vectors[k, b]
                    vectors[k, a], vectors[k, b] = c * x - s * y, s * x + c * y
    least = 0
    for a in range(1, 6):
        if gram[a, a] < gram[least, least]:
            least = a
    local = np.zeros(6)
    rows = 0
    for k in range(6):
        if not math.isinf(task.bounds[k]):
            rows += 1
    row = 0
    for k in range(6):
        if math.isinf(task.bounds[k]):
            continue
        if rows <= n:
            local[k] = vectors[row, least]
        else:
            for i in range(n):
                local[k] += work.jacobian[i, row] * vectors[i, least]
        row += 1
    length = math.sqrt(_dot6(local, local))
    for k in range(6):
        direction[k] = 0.0
        for j in range(3):
            direction[k] += task.target[k % 3, j] * local[3 * (k // 3) + j]
        if length > 0.0:
            direction[k] /= length
    return math.sqrt(max(gram[least, least], 0.0))


@compiled
def tick(
    model: Model,
    task: Task,
    lower: np.ndarray,
    upper: np.ndarray,
    reach: np.ndarray,
    iterations: int,
    damping: float,
    measured: bool,
    q: np.ndarray,
    held: np.ndarray,
    direction: np.ndarray,
) -> Tuple[bool, float, float, int, float]:
    """One tick of tracking, in place; see `Backend.tick`. Returns sigma as well."""
    n = q.size
    work = _workspace(n)
    _begin(model, task, work)
    low, high = np.empty(n), np.empty(n)
    for i in range(n):
        # Outside of their limits, joints come back at the speed limit.
        low[i] = min(max(lower[i], q[i] - reach[i]), q[i] + reach[i])
        high[i] = max(min(upper[i], q[i] + reach[i]), q[i] - reach[i])
        q[i] = min(max(q[i], low[i]), high[i])
    converged, place, turn, used = _descend(
        model, task, q, low, high, iterations, 1e-4, max(damping, _FLOOR), work
    )
    _push(work, q, low, high, held)
    for i in range(n):
        if (held[i] > 0.0 and q[i] >= upper[i]) or (held[i] < 0.0 and q[i] <= lower[i]):
            held[i] *= AT_LIMIT
    sigma = 0.0
    if measured:
        _forward(model, q, work)
        sigma = _condition(model, task, held, direction, work)
    return converged, place, turn, used, sigma


@compiled
def forward(model: Model, task: Task, q: np.ndarray, pose: np.ndarray) -> None:
    """Fill the pose, shape (4, 4), of the tip in the frame of the task's target."""
    work = _workspace(q.size)
    _begin(model, task, work)
    _forward(model, q, work)
    for row in range(3):
        for column in range(4):
            pose[row, column] = work.pose[row, column]


@compiled
def jacobian(model: Model, task: Task, q: np.ndarray, out: np.ndarray) -> None:
    """Fill the Jacobian, shape (6, n), in the frame of the task's target, weighted."""
    work = _workspace(q.size)
    _begin(model, task, work)
    _forward(model, q, work)
    _jacobian(model, task, work.active, work)
    for i in range(q.size):
        for k in range(6):
            out[k, i] = work.jacobian[i, k]
