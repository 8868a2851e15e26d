"""The tracks of one robot in PyBullet: contacts in, forces out, belts driven and loaded."""

from __future__ import annotations

from typing import Any, Callable, Dict, Iterable, List, Mapping, Optional, Sequence, Tuple

import pybullet

from telex_control.common.stateful import Stateful

from ..engine.world import Body, Vector
from ..robot.drives import JointDrive
from .belt_drive import BeltDrive
from .belt_faults import ROLLING, BeltFault, make_drive
from .law import Patch, TractionLaw, belt_directions, edge_share
from .surfaces import BodyLink, Surfaces
from .track_config import TrackConfig

_Place = Tuple[int, Optional[BodyLink]]
"""Of a patch on its track: the face, and the loose body; None for all that stands fast."""
_Footing = Tuple[_Place, float, float, Vector, Vector]
"""Of a contact: its patch's place; friction coefficients and directions along and across."""
_LOAD_SHARE = 0.5
"""Of a step's load in a track's mean.

Below 2 / (1 + mu tan(angle)) no flipper shakes that slides on its tip at an angle.
"""
_LOAD_EXCESS = 2.0
"""Of a track's mean load over that of the step, at most."""
_UNNAMED = "solid"
"""What a surface is called that nothing says the material of."""
_FIRM = (1.0, 1.0)
"""Softness of what stands fast."""
_WHEEL_TORQUE = 1.0e3
"""Bound of the motors that turn drive wheels with a collision shape (N m); they carry nothing."""


def surface_under(
    contacts: Iterable[Sequence[Any]], material_of: Optional[Callable[[int, int], str]]
) -> str:
    """What contacts of PyBullet press on most, as in `Surface.material` of scenes.

    ``solid`` where nothing says what it is; empty where there are none.

    Parameters
    ----------
    contacts : iterable of tuple
        Of the robot's own links, which come first in them.
    material_of : callable, optional
        See `Tracks`.
    """
    loads: Dict[str, float] = {}
    for contact in contacts:
        name = material_of(contact[2], contact[4]) if material_of else ""
        loads[name] = loads.get(name, 0.0) + contact[9]
    return (max(loads, key=loads.__getitem__) or _UNNAMED) if loads else ""


class _Track(Stateful):
    """A belt, the body that it runs round, and what it touches."""

    __slots__ = (
        "contacts",
        "drive",
        "handle",
        "link",
        "load",
        "patches",
        "pulled",
        "radius",
        "running",
        "state",
        "thrown",
    )
    SAVED = ("load", "pulled")

    def __init__(self, link: int, joint: JointDrive, radius: float) -> None:
        self.link = link
        self.drive = joint
        self.handle = joint.handle
        self.state = joint.state
        self.radius = radius
        self.contacts: List[Tuple] = []
        self.load = 0.0
        self.patches: Dict[_Place, Patch] = {}
        self.running: List[Patch] = []
        self.pulled = 0.0
        self.thrown = False

    def save_state(self) -> Any:
        patches = [(place, patch.save_state()) for place, patch in self.patches.items()]
        return super().save_state(), patches

    def restore_state(self, saved: Any, elapsed: float) -> None:
        state, patches = saved
        self.lift()
        super().restore_state(state, elapsed)
        for place, bent in patches:
            patch = self.patches[place] = Patch()
            patch.restore_state(bent, elapsed)

    def lift(self) -> None:
        """Forget what was touched."""
        self.load = 0.0
        self.patches.clear()
        self.running.clear()


class _Side(Stateful):
    """Belts with one drive."""

    __slots__ = ("_figures", "by_effort", "drive", "tracks")
    SAVED_PARTS = ("drive", "tracks")

    def __init__(self, tracks: Sequence[_Track], config: TrackConfig, step_size: float) -> None:
        self.tracks = tuple(tracks)
        self.by_effort = tracks[0].drive.takes_effort
        friction = damping = 0.0
        for track in tracks:
            friction += track.drive.description.friction / track.radius
            damping += track.drive.description.damping / track.radius**2
        self._figures = (config.drive, friction, damping, step_size)
        self.drive = BeltDrive(*self._figures)

    def damage(self, fault: BeltFault) -> None:
        """Let the drive and its belts work as far as a fault allows, from now on."""
        before, self.drive = self.drive, make_drive(*self._figures, fault)
        self.drive.speed, self.drive.force = before.speed, before.force
        for track in self.tracks:
            track.thrown = fault.thrown

    def pull(self, speed: float) -> float:
        """Force along the belts that they give the robot (N) at a speed (m/s)."""
        total = 0.0
        for track in self.tracks:
            pulled = 0.0
            for patch in track.running:
                pulled += patch.pull(speed)
            track.pulled = pulled
            total += pulled
        return total

    def advance(self) -> None:
        """Move the belts on by a step."""
        tracks, drive = self.tracks, self.drive
        command = 0.0
        for track in tracks:
            if track.drive.braked:
                drive.brake(self.pull)
                return
            if self.by_effort:
                command += track.drive.force / track.radius
            else:
                command += track.handle.command * track.radius
        if self.by_effort:
            drive.push(command, self.pull)
        else:
            drive.follow(command / len(tracks), self.pull)

    def report(self, step_size: float) -> None:
        """Tell the joints how they move, and with what load."""
        tracks, drive = self.tracks, self.drive
        speed = drive.speed
        loads = 0.0
        for track in tracks:
            loads += track.pulled
        # What does not go to the ground accelerates belts and rotor, or is friction.
        rest = (drive.force - loads) / len(tracks)
        for track in tracks:
            state, radius = track.state, track.radius
            state.velocity = velocity = speed / radius
            state.position += velocity * step_size
            state.effort = (track.pulled + rest) * radius


class Tracks(Stateful):
    """The tracks of one robot.

    Parameters
    ----------
    drives : mapping of str to JointDrive
        The driven joint of each belt.
    step_size : float
        Time between calls of `step` (s).
    material_of : callable, optional
        Material of a link (PyBullet's numbers of body and link).
    """

    SAVED_PARTS = ("_sides",)

    def __init__(
        self,
        body: Body,
        config: TrackConfig,
        drives: Mapping[str, JointDrive],
        step_size: float,
        material_of: Optional[Callable[[int, int], str]] = None,
    ) -> None:
        self._client = body.client
        self._uid = body.uid
        self._step_size = step_size
        self._law = TractionLaw(config.stiffness, config.damping, step_size)
        self._edge_gain = config.edge_grip - 1.0
        self._ratio = (config.lateral_friction / config.friction) ** 2
        self._surfaces = Surfaces(body.client, config, material_of)
        self._material_of = material_of
        tracks = {
            belt: _Track(body.links[body.parents[belt]], drives[belt], radius)
            for belt, radius in config.belts.items()
        }
        self._tracks = list(tracks.values())
        self._by_link = {track.link: track for track in self._tracks}
        self._links = [link for link in self._by_link if link >= 0]
        turning = [track for track in self._tracks if track.drive.description.name in body.joints]
        self._turning = turning
        self._wheels = [track.drive.index for track in turning]
        self._torques = [_WHEEL_TORQUE] * len(turning)
        self._wheel_speeds: List[float] = []
        # Of a state that was restored: what PyBullet has until the next step is of another.
        self._contacts: Optional[Sequence[Tuple]] = None
        self._angles = body.wheels
        self._shown = [(belt, track.state) for belt, track in tracks.items() if belt in body.wheels]
        self._sides = [
            _Side([tracks[belt] for belt in belts], config, step_size) for belts in config.groups()
        ]
        names = [*config.drives, *(belts[0] for belts in config.groups()[len(config.drives) :])]
        self._named = dict(zip(names, self._sides))
        for link in self._by_link:
            pybullet.changeDynamics(
                self._uid,
                link,
                lateralFriction=0.0,
                contactStiffness=config.contact_stiffness,
                contactDamping=config.contact_damping,
                physicsClientId=self._client,
            )

    def forget_surfaces(self) -> None:
        """Look at every surface anew, after bodies have come or gone."""
        self._surfaces.forget()

    @property
    def names(self) -> List[str]:
        """Names of the drives; one that the configuration gives none is called as its belt."""
        return list(self._named)

    def damage(self, name: str, fault: BeltFault) -> None:
        """Let a drive and its belts work as far as a fault allows.

        Raises
        ------
        KeyError
            There is no such drive.
        """
        self._named[name].damage(fault)

    def surface(self) -> str:
        """What the belts press on most looks to be made of, see `surface_under`."""
        contacts = (contact for track in self._tracks for contact in track.contacts)
        return surface_under(contacts, self._material_of)

    def carriers(self) -> List[int]:
        """PyBullet's numbers of the links that belts run round; -1: the root link."""
        return list(self._by_link)

    def step(self) -> Optional[Sequence[Tuple]]:
        """Apply the forces for the next step, and move the belts on.

        Returns
        -------
        sequence of tuple, optional
            PyBullet's contacts of the robot in the last step; None where it has no tracks, and
            nothing was read.
        """
        if not self._tracks:
            return None
        contacts = self._touch()
        sides, step_size = self._sides, self._step_size
        for side in sides:
            side.advance()
        self._push()
        for side in sides:
            side.report(step_size)
        self._turn_wheels()
        return contacts

    def save_state(self) -> Any:
        """Return the present state, with the contacts of the last step."""
        contacts = pybullet.getContactPoints(self._uid, physicsClientId=self._client)
        return super().save_state(), contacts

    def restore_state(self, saved: Any, elapsed: float) -> None:
        """Take a state up again, after the states of the joints were."""
        state, self._contacts = saved
        super().restore_state(state, elapsed)
        self._wheel_speeds = []
        for joint, belt in self._shown:
            self._angles[joint] = belt.position

    def _turn_wheels(self) -> None:
        """Let the drive wheels be seen to turn; PyBullet's motors go on until told otherwise."""
        for joint, state in self._shown:
            self._angles[joint] = state.position
        if not self._turning:
            return
        speeds = [track.state.velocity for track in self._turning]
        if speeds == self._wheel_speeds:
            return
        self._wheel_speeds = speeds
        pybullet.setJointMotorControlArray(
            self._uid,
            self._wheels,
            pybullet.VELOCITY_CONTROL,
            targetVelocities=speeds,
            forces=self._torques,
            physicsClientId=self._client,
        )

    def _touch(self) -> Sequence[Tuple]:
        """Find what the tracks touch; returns the contacts of the whole robot."""
        uid, client, by_link = self._uid, self._client, self._by_link
        tracks = self._tracks
        for track in tracks:
            track.contacts.clear()
        found_contacts, self._contacts = self._contacts, None
        if found_contacts is None:
            found_contacts = pybullet.getContactPoints(uid, physicsClientId=client)
        for contact in found_contacts:
            # The body that was asked for comes first; what it touches may be itself.
            if contact[9] > 0.0 and contact[2] != uid:
                found = by_link.get(contact[3])
                if found is not None:
                    found.contacts.append(contact)
        touching = False
        for track in tracks:
            if track.contacts:
                touching = True
            elif track.load:
                track.lift()
        if not touching:
            return found_contacts
        self._surfaces.begin_step()
        states = dict(zip(self._links, self._link_states()))
        for track in tracks:
            if track.contacts:
                self._sort(track, states.get(track.link) or self._root_state())
        return found_contacts

    def _link_states(self) -> Sequence[Tuple]:
        if not self._links:
            return ()
        states: Sequence[Tuple] = pybullet.getLinkStates(self._uid, self._links, 1, 1, self._client)
        return states

    def _root_state(self) -> Tuple:
        """What `_link_states` has of the others, as far as it is used here."""
        pose = pybullet.getBasePositionAndOrientation(self._uid, physicsClientId=self._client)
        speeds = pybullet.getBaseVelocity(self._uid, physicsClientId=self._client)
        return (*pose, None, None, None, None, *speeds)

    def _sort(self, track: _Track, state: Tuple) -> None:
        """Give a track's contacts to its patches, and prepare these."""
        contacts, patches = track.contacts, track.patches
        rotation = pybullet.getMatrixFromQuaternion(state[1])
        (cx, cy, cz), (vx, vy, vz), (wx, wy, wz) = state[0], state[6], state[7]
        for patch in patches.values():
            patch.touches = []
        total = 0.0
        for contact in contacts:
            total += contact[9]
        # PyBullet's normal forces are a step old. On a steep flipper that slides on its tip, each
        # newton of friction makes more than one of load: from step to step that would swing up.
        mean = track.load + _LOAD_SHARE * (total - track.load) if track.load else total
        track.load = load = min(mean, _LOAD_EXCESS * total)
        scale = load / total
        last: Optional[Vector] = None
        before: Optional[BodyLink] = None
        for contact in contacts:
            other, normal = (contact[2], contact[4]), contact[7]
            if normal != last or other != before:
                # The points of an edge or a face follow one another, and share its normal.
                last, before = normal, other
                place, along, across, forward, sideways = self._footing(other, rotation, normal)
                (a, b, c), (d, e, f) = forward, sideways
                body = place[1]
                found = patches.get(place)
                if found is None:
                    found = patches[place] = Patch()
                touches = found.touches
            if along <= 0.0 or across <= 0.0:
                continue
            point = contact[5]
            x, y, z = point
            x, y, z = x - cx, y - cy, z - cz
            u, v, w = vx + wy * z - wz * y, vy + wz * x - wx * z, vz + wx * y - wy * x
            if body is not None:
                x, y, z = self._surfaces.velocity(body, point)
                u, v, w = u - x, v - y, w - z
            touches.append(
                (
                    scale * contact[9],
                    along,
                    across,
                    u * a + v * b + w * c,
                    u * d + v * e + w * f,
                    forward,
                    sideways,
                    point,
                )
            )
        self._prepare(track, load)

    def _footing(self, other: BodyLink, rotation: Sequence[float], normal: Vector) -> _Footing:
        """What a contact with a link has of its direction and its material."""
        surface = self._surfaces.of(other)
        xx, yx, _, xy, yy, _, xz, yz, _ = rotation
        face, forward, sideways = belt_directions((yx, yy, yz), (xx, xy, xz), normal)
        if face:
            along = across = surface.flank
        else:
            along, across = surface.along, surface.across
            share = edge_share(self._surfaces.steepness(other, surface, normal))
            if share > 0.0:
                along *= 1.0 + share * self._edge_gain
        body = other if surface.mass > 0.0 else None
        return (face, body), along, across, forward, sideways

    def _prepare(self, track: _Track, load: float) -> None:
        law, patches, running = self._law, track.patches, track.running
        running.clear()
        gone = []
        for place, patch in patches.items():
            if not patch.touches:
                gone.append(place)
                continue
            face, body = place
            softness = _FIRM
            if body is not None:
                surface = self._surfaces.of(body)
                softness = law.softness(surface.mass, surface.weight, patch.load, load)
            if face:
                patch.prepare(law, load, softness, 1.0)
                patch.pull(0.0)
            elif track.thrown:
                patch.touches = [(t[0], ROLLING * t[1], *t[2:]) for t in patch.touches]
                patch.prepare(law, load, softness, self._ratio)
                patch.pull(0.0)
            else:
                patch.prepare(law, load, softness, self._ratio)
                running.append(patch)
        for place in gone:
            del patches[place]

    def _push(self) -> None:
        """Apply what the patches found, and its reaction on loose bodies."""
        uid, client, apply = self._uid, self._client, pybullet.applyExternalForce
        frame = pybullet.WORLD_FRAME
        for track in self._tracks:
            link = track.link
            for (_, body), patch in track.patches.items():
                patch.commit()
                for touch, (along, across) in zip(patch.touches, patch.forces):
                    (a, b, c), (d, e, f), point = touch[5], touch[6], touch[7]
                    x, y, z = along * a + across * d, along * b + across * e, along * c + across * f
                    apply(uid, link, (x, y, z), point, frame, client)
                    if body is not None:
                        apply(body[0], body[1], (-x, -y, -z), point, frame, client)
