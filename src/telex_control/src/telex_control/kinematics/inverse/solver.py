"""Inverse kinematics of one chain: solved at once, or tracked tick by tick."""

from __future__ import annotations

import math
import time
from collections import deque
from typing import TYPE_CHECKING, Any, Deque, Dict, List, Optional, Tuple

import numpy as np

from telex_control.common.geometry.matrices import Floats, rotation_vector
from telex_control.common.plausible import LARGEST_POSITION, LARGEST_SPEED, LONGEST

from ..chain import Chain
from ..poses import (
    BASE,
    PoseLine,
    check_frame,
    check_pose,
    move_pose,
    positive,
    turned,
    vector,
)
from ..urdf_tree import KinematicsError
from .options import Goal, IKOptions, Mode, Tolerance
from .reconfiguration import PostureSearch
from .result import IKResult, IKStatus, TrackResult
from .task import (
    AT_LIMIT,
    AT_SPEED,
    DISTANCE,
    SINGULARITY,
    GoalFunction,
    SearchOutcome,
    Task,
    TaskShape,
    Tick,
)

if TYPE_CHECKING:
    from .numerics import ChainNumerics

_SLICE = 100
"""Iterations between two looks at the clock."""
_SLIDES = 20
"""Steps towards a secondary goal, of a solution."""
ACCELERATION_TIME = 0.3
"""s from rest to the speed limit, as the controllers' ``command_limits`` have it."""
_EVEN = 1e-6
"""Difference of a tick's length from the last one's, as a share, that is taken for rounding."""
_UNEVEN, _SHORTEST = 0.5, 0.125
"""Where ticks are uneven, braking is planned in ticks of `_UNEVEN` of the shortest of late, though
of no less than `_SHORTEST` of the present one. The shorter a tick, the less speed a corner of the
path allows in it; and uneven ticks meet corners elsewhere than planned."""
_FORGET = 1.01
"""Growth, in a tick, of the length that is planned with."""
_TICK = 1e-6
"""s; no control loop is faster."""
_LATEST = 10.0
"""s of a path before the joints; beyond, they go straight to where the target is."""
_TRIALS = 20
"""Postures that are tried in a tick on the straight lines to targets that are far."""
_LEAST_PART = 1e-5
"""Of such a line; joints that must go farther for less would jump."""
_FULL = 1.0 - 1e-6
"""Share of the speed limit from which a joint counts as running at it."""
_MOST_SHAPES = 64
"""Tolerances whose tasks are kept prepared; each question may have its own."""
_FINE = 1e-9
"""Tolerance (m, rad) of a twist's tick: its error must not add up over a minute."""

Box = Tuple[np.ndarray, np.ndarray]
Bounds = Tuple[Floats, Floats]


class IKSolver:
    """Inverse kinematics of a chain, inside its joints' limits. One thread may use it at a time.

    Answers depend on nothing but the arguments, unless `IKOptions.time_limit` is set; those of
    `track` also on the ticks before: whether another posture is known to reach the target.

    Parameters
    ----------
    velocity_limits : sequence of float, shape (n,), optional
        Replace the URDF's (rad/s, m/s) in tracking.
    position_limits : pair of sequences of float, shape (n,), optional
        Lower and upper limits (rad, m) inside those of the URDF, which they replace.

    Attributes
    ----------
    numerics : ChainNumerics
        The compiled kinematics that it computes with.

    Raises
    ------
    KinematicsError
        No joint of the chain can move, limits are wrong, or numba does not load.
    """

    def __init__(
        self,
        chain: Chain,
        options: Optional[IKOptions] = None,
        *,
        velocity_limits: Optional[Floats] = None,
        position_limits: Optional[Bounds] = None,
    ) -> None:
        self.chain = chain
        self.options = options or IKOptions()
        self._names = chain.joint_names
        self._count = len(self._names)
        self._box = self._position_box(position_limits)
        if not (self._box[0] < self._box[1]).any():
            raise KinematicsError(f"no joint from {chain.base} to {chain.tip} can move")
        self._speeds = chain.velocity_limits
        if velocity_limits is not None:
            self._speeds = vector(velocity_limits, self._count, "velocity_limits")
            if not (self._speeds > 0.0).all():
                raise KinematicsError(
                    f"velocity_limits is {self._speeds.tolist()}; numbers above 0 are needed"
                )
        self._without_speed = [
            joint.name
            for joint, speed in zip(chain.joints, self._speeds)
            if not 0.0 < speed < math.inf
        ]
        lower, upper = self._box
        self._bounded = np.isfinite(lower) & np.isfinite(upper)
        self._middle = np.zeros(self._count)
        self._middle[self._bounded] = 0.5 * (lower[self._bounded] + upper[self._bounded])
        self.numerics = _numerics(chain, self.options)
        self._iterations = int(self.options.iterations or self.numerics.default_iterations)
        self._shapes: Dict[Optional[Tolerance], TaskShape] = {}
        for tolerance in (None, self.options.tolerance):
            self._shapes[tolerance] = self._shape(self.options.tolerance)
        self._search = PostureSearch(self.numerics, self._box, self.options)
        # Not imported before numba is needed: see `_numerics`.
        from .posture_path import PosturePath

        self._way = PosturePath(self._count)
        self._full_speeds = (_FULL * self._speeds).tolist()
        self._standing = np.zeros(self._count)
        self._on_path: Optional[np.ndarray] = None  # pose of the way's end, while on the path
        self._ahead: Deque[np.ndarray] = deque()  # targets that it has still to be led to
        self._last_dt = math.nan
        self._planned_dt = math.inf

    def warm_up(self) -> None:
        """Compile, or load from the cache, what will be needed. Takes seconds the first time."""
        target = self.numerics.forward(self._middle)
        task = self._shape_of(None).at(target)
        middle = self._middle.copy()
        self.numerics.jacobian(middle)
        self.numerics.solve(task, middle, self._box, self.numerics.random(0), 1)
        self.numerics.descend(task, middle, self._box, 1)
        self.numerics.tick(task, middle, self._box, np.ones(self._count), 1)
        self._way.warm_up()
        for kind in (DISTANCE, SINGULARITY):
            goal = GoalFunction(kind, middle, np.ones(self._count))
            self.numerics.goal_value(task, middle, goal)
            self.numerics.slide(task, middle, self._box, goal, 1)

    # ---------------------------------------------------------------- at once

    def solve(
        self,
        target: np.ndarray,
        seed: Optional[Floats] = None,
        tolerance: Optional[Tolerance] = None,
    ) -> IKResult:
        """Return joint positions that bring the tip to a pose, or as near to it as can be found.

        Parameters
        ----------
        target : ndarray, shape (4, 4)
            Of the tip in the base frame (m).
        seed : sequence of float, shape (n,), optional
            Where to begin (rad, m), and what to stay near to; may lie outside the limits, up to
            `plausible.LARGEST_POSITION`. The middle of the joints' ranges without it.
        tolerance : Tolerance, optional
            Instead of that of the options.

        Returns
        -------
        IKResult

        Raises
        ------
        KinematicsError
            The target is no pose, or the seed no posture. Never because of where the target is.
        """
        task = self._task(target, tolerance)
        start = self._middle
        if seed is not None:
            start = vector(seed, self._count, "seed", LARGEST_POSITION)
        options = self.options
        random = self.numerics.random(options.random_seed)
        if options.mode == Mode.BEST:
            outcome = self._best(task, start, random)
        else:
            outcome = self._first(task, start, random)
            if options.goal != Goal.NONE and outcome.converged:
                outcome = self._slide(task, outcome, self._goal(start))
        status = IKStatus.CONVERGED if outcome.converged else IKStatus.BEST_EFFORT
        q, _, place, turn, iterations, restarts = outcome
        return IKResult(q, status, place, turn, iterations, restarts)

    def _first(self, task: Task, start: np.ndarray, random: Any) -> SearchOutcome:
        """Return the first solution found within the budget."""
        options = self.options
        if options.time_limit is None:
            return self.numerics.solve(task, start, self._box, random, self._iterations)
        end = time.monotonic() + options.time_limit
        slices = _Slices(self._iterations)
        while slices.left and not slices.converged and time.monotonic() < end:
            slices.add(self._slice(task, start, random, slices))
        return slices.outcome(task.length_weight)

    def _best(self, task: Task, start: np.ndarray, random: Any) -> SearchOutcome:
        """Return that of all solutions found within the budget which meets the goal best."""
        options, goal = self.options, self._goal(start)
        end = math.inf if options.time_limit is None else time.monotonic() + options.time_limit
        slices = _Slices(self._iterations)
        best, least = None, math.inf
        while slices.left and time.monotonic() < end:
            found = self._slice(task, start, random, slices)
            if found.converged:
                found = self._slide(task, found, goal)
            slices.add(found)
            if not found.converged:
                continue
            value = self.numerics.goal_value(task, found.q, goal)
            if value < least:
                best, least = found, value
        if best is None:
            return slices.outcome(task.length_weight)
        return best._replace(iterations=slices.iterations, restarts=slices.restarts)

    def _slice(self, task: Task, start: np.ndarray, random: Any, slices: _Slices) -> SearchOutcome:
        return self.numerics.solve(
            task,
            start,
            self._box,
            random,
            min(_SLICE, slices.left),
            restart=slices.iterations > 0,
        )

    def _slide(self, task: Task, outcome: SearchOutcome, goal: GoalFunction) -> SearchOutcome:
        """Move a solution towards the goal; the answer is a solution as well."""
        moved, used = self.numerics.slide(task, outcome.q, self._box, goal, _SLIDES)
        checked = self.numerics.descend(task, moved, self._box, 1)
        iterations = outcome.iterations + used
        if not checked.converged:
            return outcome._replace(iterations=iterations)
        return checked._replace(iterations=iterations, restarts=outcome.restarts)

    def _goal(self, start: np.ndarray) -> GoalFunction:
        kind = SINGULARITY if self.options.goal == Goal.MANIPULABILITY else DISTANCE
        if self.options.goal == Goal.MID_RANGE:
            half = np.full(self._count, math.inf)
            lower, upper = self._box
            movable = self._bounded & (lower < upper)
            half[movable] = 0.5 * (upper - lower)[movable]
            return GoalFunction(kind, self._middle, half)
        return GoalFunction(kind, start, np.ones(self._count))

    # ---------------------------------------------------------------- tick by tick

    def track(
        self,
        target: np.ndarray,
        q: Floats,
        dt: float,
        tolerance: Optional[Tolerance] = None,
        acceleration_time: Optional[float] = ACCELERATION_TIME,
    ) -> TrackResult:
        """Move on towards a pose for one tick, inside position, speed and acceleration limits.

        Without a jump ever: out of reach, the tip comes as near as the present posture allows.
        Where another posture reaches the target, and the target stands still
        (`IKOptions.reconfigure_after`), the joints walk there.
        With `IKOptions.goal` ``mid_range`` or ``manipulability``, what the target leaves open is
        used for the goal.

        Where a limit binds, the tip is late on the targets' path (straight from each to the next),
        not beside it, and never so fast that it could not come to rest where the path ends.

        Parameters
        ----------
        target : ndarray, shape (4, 4)
            Of the tip in the base frame (m).
        q : sequence of float, shape (n,)
            The present references (rad, m). Outside of the limits, they are led back. Joints that
            are not where the last tick left them are taken to be at rest.
        dt : float
            Length of the tick (s), which may differ from the last one's.
        tolerance : Tolerance, optional
            Instead of that of the options.
        acceleration_time : float, optional
            s from rest to a joint's speed limit, which is its acceleration limit. None for no such
            limit: where the speed limit binds, the tip then takes the nearest way to the target.

        Returns
        -------
        TrackResult

        Raises
        ------
        KinematicsError
            The target is no pose, `q` no posture, `dt` or `acceleration_time` not above 0, or a
            joint has no speed limit. Never because of where the target is.
        """
        task = self._task(target, tolerance)
        here = vector(q, self._count, "q", LARGEST_POSITION)
        reach = self._reach(dt)
        if acceleration_time is None:
            self.rest()
            return self._answer(here, dt, *self._lead(task, here, reach, dt))
        change = reach * (dt / positive(acceleration_time, "acceleration_time"))
        way = self._way
        if not way.stands_at(here) or self._last_dt != dt:
            self._take_up(here, dt)
        self._planned_dt = min(max(_FORGET * self._planned_dt, _SHORTEST * dt), dt)
        was_late = way.count > 0
        tick, status, posture = self._lengthen(task, reach, dt)
        way.advance(reach, change, self._planned_dt / dt)
        if tick is not None and way.count == 0 and not was_late:
            return self._answer(here, dt, tick, status, posture)
        moved = way.position
        tick = self.numerics.tick(task, moved, self._box, self._standing, 0)
        if tick.outcome.converged:
            status = IKStatus.CONVERGED
        elif status is IKStatus.CONVERGED:
            status = IKStatus.LAGGING
        return self._answer(here, dt, tick, status, posture, late=True)

    def rest(self) -> None:
        """Take the joints to be at rest in the next tick of `track`: nobody followed the last."""
        self._last_dt = math.nan

    def _take_up(self, here: np.ndarray, dt: float) -> None:
        """Go on from where the joints are, in ticks of a length."""
        if self._way.stands_at(here) and self._last_dt > 0.0:
            self._way.step *= dt / self._last_dt
            if abs(dt - self._last_dt) > _EVEN * dt:
                self._planned_dt = min(self._planned_dt, _UNEVEN * min(dt, self._last_dt))
        else:
            self._way.begin(here)
            self._on_path = self.numerics.forward(here)
            self._ahead.clear()
        self._last_dt = dt

    def _lengthen(
        self, task: Task, reach: np.ndarray, dt: float
    ) -> Tuple[Optional[Tick], IKStatus, Optional[np.ndarray]]:
        """Lead the end of the way towards a target; the joints follow on it.

        Returns the tick of the end, None while it is on the way to the target.
        """
        way = self._way
        if max(way.count, len(self._ahead)) * self._planned_dt > _LATEST:
            way.shorten(entirely=True)
            self._leave_path()
        if self._ahead:
            if (task.target != self._ahead[-1]).any():
                self._ahead.append(task.target)
            self._lead_along(task, reach)
            return None, IKStatus.LAGGING, None
        # Joints that are late already end the tick elsewhere, and are looked at there.
        end = way.end
        tick, status, posture = self._lead(task, end, reach, dt, measured=way.count == 0)
        if status is IKStatus.CONVERGED:
            # Of a target that stands while joints are late, one posture is enough.
            if way.count == 0 or self._on_path is None or (tick.outcome.q != end).any():
                way.append(tick.outcome.q, firm=True)
            self._on_path = task.target
        elif status is IKStatus.LAGGING and self._on_path is not None:
            self._ahead.append(task.target)
            if self._lead_along(task, reach):
                return None, status, None
        else:
            self._leave_path()
        if self._on_path is None:
            # Beside the path anyway: what comes next needs no detour by what was nearest before.
            way.shorten()
            way.append(tick.outcome.q, firm=False)
        return (None if status is IKStatus.LAGGING else tick), status, posture

    def _leave_path(self) -> None:
        self._on_path = None
        self._ahead.clear()

    def _lead_along(self, task: Task, reach: np.ndarray) -> bool:
        """Lead the end of the way on along the straight lines to the targets ahead.

        From each posture to the next it is as far as joints reach in a tick, or less. Where a line
        cannot be followed without a jump, the path is left. Tells whether the way has grown.
        """
        assert self._on_path is not None
        way, end, grown = self._way, self._way.end, False
        line, share, part = PoseLine(self._on_path, self._ahead[0]), 0.0, 1.0
        for _ in range(_TRIALS):
            there = min(share + part, 1.0)
            pose = line.at(there) if there < 1.0 else self._ahead[0]
            found = self.numerics.descend(
                task._replace(target=pose), end, self._box, self.options.track_iterations
            )
            # The largest of plain floats: numpy's own takes several times as long on so few.
            ticks: float = max((abs(found.q - end) / reach).tolist())
            if found.converged and ticks <= 1.0:
                way.append(found.q, firm=True)
                self._on_path, end, share, grown = pose, found.q, there, True
                part *= 2.0
                if share == 1.0:
                    self._ahead.popleft()
                    if not self._ahead:
                        break
                    line, share, part = PoseLine(pose, self._ahead[0]), 0.0, 1.0
            else:
                # Nearly as much as reaches; not converged, that says little.
                part *= max(0.1, 0.9 / ticks) if found.converged else 0.25
                if part < _LEAST_PART:
                    self._leave_path()
                    break
        return grown

    def _lead(
        self, task: Task, here: np.ndarray, reach: np.ndarray, dt: float, *, measured: bool = True
    ) -> Tuple[Tick, IKStatus, Optional[np.ndarray]]:
        """Move on towards a pose for one tick, inside position and speed limits."""
        destination = self._search.destination(task)
        if destination is not None:
            return self._walk(task, here, reach, destination)
        tick = self.numerics.tick(
            task, here, self._box, reach, self.options.track_iterations, measured=measured
        )
        if tick.outcome.converged:
            self._search.forget()
            if self.options.goal in (Goal.MID_RANGE, Goal.MANIPULABILITY):
                tick = self._use_freedom(task, here, reach, tick)
            return tick, IKStatus.CONVERGED, None
        # In a list: in an array so small, to look takes a hundred times as long.
        held = tick.held.tolist()
        if AT_SPEED in held or -AT_SPEED in held:
            return tick, IKStatus.LAGGING, None
        posture = self._search.look(task, tick.outcome.q, float(dt))
        status = IKStatus.BEST_EFFORT if posture is None else IKStatus.NEEDS_RECONFIGURE
        return tick, status, posture

    def _walk(
        self, task: Task, here: np.ndarray, reach: np.ndarray, destination: np.ndarray
    ) -> Tuple[Tick, IKStatus, Optional[np.ndarray]]:
        """Go on to another posture, all joints arriving together."""
        way = destination - here
        ticks = max(1.0, float((abs(way) / reach).max()))
        moved = here + way / ticks if ticks > 1.0 else destination
        tick = self.numerics.tick(task, moved, (moved, moved), np.zeros(self._count), 0)
        if tick.outcome.converged:
            self._search.forget()
            return tick, IKStatus.CONVERGED, None
        tick.held[:] = 0.0
        return tick, IKStatus.NEEDS_RECONFIGURE, destination

    def _use_freedom(self, task: Task, here: np.ndarray, reach: np.ndarray, tick: Tick) -> Tick:
        """Move on towards the goal, with what a tick that has reached its target leaves."""
        goal = self._goal(here)
        box = self._tick_box(here, reach)
        moved, _ = self.numerics.slide(task, tick.outcome.q, box, goal, 1)
        checked = self.numerics.tick(task, moved, box, np.zeros(self._count), 0)
        return checked if checked.outcome.converged else tick

    def track_twist(
        self,
        twist: Floats,
        q: Floats,
        dt: float,
        frame: str = BASE,
        tolerance: Optional[Tolerance] = None,
    ) -> TrackResult:
        """Move the tip on with a velocity for one tick, inside position and speed limits.

        Where a speed limit binds, the whole twist is slowed down, so that the direction is kept.
        Along a position limit the tip slides. Near a singularity joint speeds are damped, and with
        them what the tip does of the twist.

        Parameters
        ----------
        twist : sequence of 6 floats
            Velocity of the tip's origin (m/s), and its rotation about it (rad/s).
        q : sequence of float, shape (n,)
            The present references (rad, m). Outside of the limits, they are led back.
        dt : float
            Length of the tick (s).
        frame : str
            Along whose axes the twist is given: ``base`` or ``tool``, the tip's.
        tolerance : Tolerance, optional
            Bounds that are infinite leave their component of the twist open.

        Returns
        -------
        TrackResult
            CONVERGED when the whole twist is carried out, LAGGING when a speed limit slows it down,
            else BEST_EFFORT. Errors are those at the end of the tick.

        Raises
        ------
        KinematicsError
            A number is not finite, the frame unknown, `dt` not above 0, or a joint has no speed
            limit.
        """
        speeds = vector(twist, 6, "twist", LARGEST_SPEED)
        check_frame(frame)
        here = vector(q, self._count, "q", LARGEST_POSITION)
        reach = self._reach(dt)
        shape = self._shape_of(tolerance)
        fine = shape._replace(position=_FINE, rotation=_FINE)
        numerics, box = self.numerics, self._box
        begin = numerics.forward(here)
        target = move_pose(begin, speeds, dt, frame)
        damping = self._damping(numerics.tick(fine.at(target), here, box, reach, 0).sigma)
        # Damped, more than one step would end where an undamped one does.
        iterations = self.options.track_iterations if damping == 0.0 else 1
        # Without speed limits first: by how much they are exceeded is by how much to slow down.
        wanted = numerics.descend(fine.at(target), here, box, iterations, damping).q
        loads = abs(wanted - here) / reach
        slowest = int(np.argmax(loads))
        share = min(1.0, 1.0 / float(loads[slowest])) if loads[slowest] > 0.0 else 1.0
        slowed = target if share == 1.0 else move_pose(begin, speeds * share, dt, frame)
        moved = numerics.tick(fine.at(slowed), here, box, reach, iterations, damping)
        tick = moved._replace(outcome=self._against(shape.at(target), moved.outcome.q))
        if share < 1.0 and tick.held[slowest] == 0.0:
            tick.held[slowest] = math.copysign(AT_SPEED, wanted[slowest] - here[slowest])
        if tick.outcome.converged:
            status = IKStatus.CONVERGED
        else:
            status = IKStatus.LAGGING if share < 1.0 else IKStatus.BEST_EFFORT
        asked = speeds * dt
        if frame == BASE:
            asked = turned(begin.T, asked)
        ratio = self._share_done(shape, begin, numerics.forward(tick.outcome.q), asked)
        return self._answer(here, dt, tick, status, twist_ratio=ratio)

    def _against(self, task: Task, q: np.ndarray) -> SearchOutcome:
        """Return how a posture stands to a target."""
        return self.numerics.descend(task, q, (q, q), 0)

    def _share_done(
        self, shape: TaskShape, begin: np.ndarray, end: np.ndarray, asked: np.ndarray
    ) -> float:
        """Projection of the move that was made on the asked one (tip's frame), as a share of it."""
        weights = np.array([shape.length_weight] * 3 + [1.0] * 3)
        weights[np.isinf(shape.bounds)] = 0.0
        made = np.empty(6)
        made[:3] = begin[:3, :3].T @ (end[:3, 3] - begin[:3, 3])
        made[3:] = rotation_vector(begin[:3, :3].T @ end[:3, :3])
        asked = weights * asked
        length = float(asked @ asked)
        if length == 0.0:
            return 1.0
        return min(max(float(asked @ (weights * made)) / length, 0.0), 1.0)

    def _damping(self, sigma: float) -> float:
        """Damping of a twist's tick near a singularity.

        Y. Nakamura, H. Hanafusa, Inverse kinematic solutions with singularity robustness, J.
        Dynamic Systems, Measurement and Control 108 (1986): none far from it, growing towards it.
        """
        share = sigma / self.options.singular_below
        if share >= 1.0:
            return 0.0
        return (1.0 - share) ** 2 * self.options.singular_below**2

    def _answer(
        self,
        here: np.ndarray,
        dt: float,
        tick: Tick,
        status: IKStatus,
        posture: Optional[np.ndarray] = None,
        *,
        twist_ratio: float = 1.0,
        late: bool = False,
    ) -> TrackResult:
        q = tick.outcome.q
        velocity = (q - here) / dt
        at_limits: Tuple[str, ...] = ()
        at_speed: Tuple[str, ...] = ()
        if status is not IKStatus.CONVERGED:
            how = [abs(each) for each in tick.held.tolist()]
            if AT_LIMIT in how:
                at_limits = tuple(name for name, each in zip(self._names, how) if each == AT_LIMIT)
            if late:
                pairs = zip(velocity.tolist(), self._full_speeds)
                how = [AT_SPEED if abs(each) >= full else 0.0 for each, full in pairs]
            if AT_SPEED in how:
                at_speed = tuple(name for name, each in zip(self._names, how) if each == AT_SPEED)
        return TrackResult(
            q=q,
            velocity=velocity,
            status=status,
            position_error=tick.outcome.position_error,
            orientation_error=tick.outcome.orientation_error,
            at_limits=at_limits,
            at_speed=at_speed,
            margins=np.minimum(q - self._box[0], self._box[1] - q),
            sigma=tick.sigma,
            singular=tick.sigma < self.options.singular_below,
            singular_direction=tick.direction,
            twist_ratio=twist_ratio,
            posture=posture,
        )

    def _reach(self, dt: float) -> np.ndarray:
        """How far each joint may move in a tick."""
        if not _TICK <= positive(dt, "dt") <= LONGEST:
            raise KinematicsError(f"dt is {dt!r}; {_TICK:g} to {LONGEST:g} (s) is needed")
        if self._without_speed:
            raise KinematicsError(
                f"no speed limit above 0 for {', '.join(self._without_speed)}; give <limit "
                "velocity=...> in the URDF, or velocity_limits"
            )
        return self._speeds * dt

    def _tick_box(self, here: np.ndarray, reach: np.ndarray) -> Box:
        """Where joints that are inside their limits may be after a tick."""
        return np.maximum(self._box[0], here - reach), np.minimum(self._box[1], here + reach)

    # ---------------------------------------------------------------- arguments

    def _position_box(self, limits: Optional[Bounds]) -> Box:
        lower, upper = self.chain.lower, self.chain.upper
        if limits is None:
            return lower, upper
        try:
            low, high = limits
            own = tuple(np.array(side, dtype=float, order="C") for side in (low, high))
        except (TypeError, ValueError):
            raise KinematicsError(
                f"position_limits is {limits!r:.80}; lower and upper limits are needed"
            ) from None
        for side in own:
            if side.shape != lower.shape or np.isnan(side).any():
                raise KinematicsError(
                    f"position_limits has {side.tolist()}; {self._count} numbers are needed"
                )
        for i, joint in enumerate(self.chain.joints):
            if not lower[i] <= own[0][i] <= own[1][i] <= upper[i]:
                raise KinematicsError(
                    f"position_limits of {joint.name} are {own[0][i]:g} to {own[1][i]:g}; they "
                    f"must lie within {lower[i]:g} to {upper[i]:g}"
                )
        return own[0], own[1]

    def _task(self, target: np.ndarray, tolerance: Optional[Tolerance]) -> Task:
        return self._shape_of(tolerance).at(check_pose(target, "target"))

    def _shape_of(self, tolerance: Optional[Tolerance]) -> TaskShape:
        shape = self._shapes.get(tolerance)
        if shape is None:
            if len(self._shapes) >= _MOST_SHAPES:
                del self._shapes[next(iter(self._shapes))]
            shape = self._shapes[tolerance] = self._shape(tolerance or self.options.tolerance)
        return shape

    def _shape(self, tolerance: Tolerance) -> TaskShape:
        return TaskShape.of(tolerance, self.options.length_weight)


class _Slices:
    """A search in slices: what has been used, and the best so far."""

    def __init__(self, iterations: int) -> None:
        self.left = iterations
        self.iterations = 0
        self.restarts = 0
        self._found: List[SearchOutcome] = []
        self.converged = False

    def add(self, outcome: SearchOutcome) -> None:
        """Take the next slice's outcome."""
        self.left = max(self.left - outcome.iterations, 0)
        self.iterations += outcome.iterations
        self.restarts += outcome.restarts
        self.converged = self.converged or outcome.converged
        self._found.append(outcome)

    def outcome(self, length_weight: float) -> SearchOutcome:
        """Return the best of all slices."""

        def cost(each: SearchOutcome) -> Tuple[bool, float]:
            place = length_weight * each.position_error
            return not each.converged, place * place + each.orientation_error**2

        best = min(self._found, key=cost)
        return best._replace(iterations=self.iterations, restarts=self.restarts)


def _numerics(chain: Chain, options: IKOptions) -> ChainNumerics:
    # Imported only when asked for: numba takes half a second and 115 MB, which a process that
    # computes no inverse kinematics should not pay.
    try:
        from .numerics import ChainNumerics
    except ImportError as error:
        # There is none, or it was made for another version of numpy.
        raise KinematicsError(
            f"inverse kinematics needs numba, which does not load: {error}; "
            "./launch_scripts/setup.sh installs what requirements.txt names"
        ) from error
    return ChainNumerics(chain, options)
