"""Checks of an exercise against its scene and the robot: what nothing could measure is named."""

from __future__ import annotations

import subprocess
import tempfile
from pathlib import Path
from typing import Any, Dict, Iterator, List, Mapping, Optional, Set

import yaml

from telex_control.common.file_catalog import package_path
from telex_control.common.params import ConfigError
from telex_sim.malfunctions.described import described_parts
from telex_sim.malfunctions.kinds import Parts
from telex_sim.scene.library import object_types
from telex_sim.scene.model import Motion, Scene, SceneObject
from telex_sim.scene.robot_in_scene import robot_description

from .conditions import EVENTS, FLOOR, ROBOT, TOOL, Condition
from .exercise_file import ExerciseError, ExerciseFile
from .findings import Finding
from .metric_kinds import DIGITS, SURVEYED
from .model import ALL, ANY, MODES, Exercise, PutBack
from .questions import read_objects, right_answers
from .robot_needs import lacking
from .seeds import scene_of, scene_text

GROUPS = ("base", "tracks", "arm", "gripper")
"""Groups of the robot's links that the simulator tells contacts of."""
_ANOTHER_ROBOT = "another robot"
_HEIGHT = 0.112
"""Of base_link above the ground where it starts (m)."""
_OTHER_SEEDS = (2, 3)
_SHOWN = {
    "gap": ("gap", 0.4),
    "hurdle": ("height", 0.5),
    "inclined_plane": ("angle", 0.79),
    "stairs": ("rise", 0.2),
}
"""By type of object: a parameter, and up to where scripted operators have shown that it goes."""


def check_file(file: ExerciseFile, with_robot: bool = True) -> List[Finding]:
    """Check an exercise in all of its settings.

    Parameters
    ----------
    with_robot : bool
        Whether to make the robot and put it into each scene, too; that takes some seconds.

    Returns
    -------
    list of Finding
        What holds for every setting stands there once.
    """
    several = len(file.settings) > 1
    urdfs: Dict[str, str] = {}
    found: Dict[Finding, List[str]] = {}
    for name, exercise in file.settings.items():
        for finding in check_exercise(exercise, urdfs if with_robot else None):
            found.setdefault(finding, []).append(name)
    made = []
    for finding, names in found.items():
        everywhere = len(names) == len(file.settings)
        label = "" if everywhere or not several else f"setting {', '.join(names)}: "
        made.append(Finding(f"{label}{finding.where}", finding.text, finding.wrong))
    return made


def check_exercise(exercise: Exercise, urdfs: Optional[Dict[str, str]] = None) -> List[Finding]:
    """Check an exercise in one setting.

    Parameters
    ----------
    urdfs : dict of str to str, optional
        URDFs by variant, which it fills; None: leave the robot out.
    """
    seed = exercise.seeds.practice or 0
    try:
        text = scene_text(exercise, seed)
        scene = scene_of(exercise, text)
    except ExerciseError as error:
        return [Finding("scene", _without_file(str(error), exercise.path))]
    found = list(_Checker(exercise, scene).findings())
    names = {item.name for item in scene.objects}
    try:
        if names.issuperset(read_objects(exercise)):
            right_answers(exercise, text)
    except ExerciseError as error:
        found.append(Finding("scene", _without_file(str(error), exercise.path)))
    found += _beyond(yaml.safe_load(text))
    if urdfs is not None:
        found += _check_robot(exercise, urdfs)
    return found


def _without_file(text: str, path: Path) -> str:
    for prefix in (f"{path}: ", "scene: "):
        text = text[len(prefix) :] if text.startswith(prefix) else text
    return text


class _Checker:
    """One exercise in its scene, without the robot."""

    def __init__(self, exercise: Exercise, scene: Scene) -> None:
        self._exercise = exercise
        self._scene = scene
        self._objects: Dict[str, SceneObject] = {item.name: item for item in scene.objects}

    def findings(self) -> Iterator[Finding]:
        yield from self._zones()
        for where, condition in self._exercise.conditions():
            for part in condition.walk():
                for text in self._condition(part):
                    yield Finding(f"{where}/{part.kind}", text)
        yield from self._names()
        yield from self._start()
        yield from self._questions()
        yield from self._doses()
        yield from self._hints()

    def _zones(self) -> Iterator[Finding]:
        half = 0.5 * self._scene.floor.size
        for name, zone in self._exercise.zones.items():
            where = f"zones/{name}"
            if zone.of:
                if zone.of not in self._objects:
                    yield Finding(f"{where}/of", self._unknown(zone.of))
                continue
            x, y, z = zone.center
            if max(abs(x), abs(y)) > half:
                yield Finding(
                    f"{where}/center",
                    f"it is {list(zone.center)}, outside of the scene's floor, which goes to"
                    f" {half:g} m",
                )
            tall = zone.size[2] if zone.size is not None else zone.height
            if tall is not None and z + 0.5 * tall <= 0.0:
                yield Finding(where, "all of it is below the floor; a greater z is needed")
        used = {
            zone
            for _, condition in self._exercise.conditions()
            for part in condition.walk()
            for zone in part.zones()
        }
        if self._exercise.survey is not None:
            used.update(self._exercise.survey.points)
        for name in sorted(set(self._exercise.zones) - used):
            yield Finding(f"zones/{name}", "no condition names it", wrong=False)

    def _condition(self, part: Condition) -> Iterator[str]:
        given = part.of
        if part.kind in ("inside", "tilted", "moved"):
            yield from self._what(given.what, part.kind)
        elif part.kind in ("joint", "latch"):
            yield from self._joint(given.object, given.joint, part.kind == "latch")
        elif part.kind in ("held", "dropped") and given.object:
            yield from self._movable(given.object)
        elif part.kind in ("touches", "force"):
            if given.object not in (FLOOR, _ANOTHER_ROBOT, *self._objects):
                yield self._unknown(given.object)
            if given.group not in ("", *GROUPS):
                yield f"group is '{given.group}'; {', '.join(GROUPS)} are possible"
        elif part.kind == "answered":
            names = [question.name for question in self._exercise.questions]
            if given.question not in names:
                yield f"question is '{given.question}'; there are: {', '.join(names) or 'none'}"

    def _what(self, what: str, kind: str) -> Iterator[str]:
        if what == ROBOT or (what == TOOL and kind != "tilted"):
            return
        name, _, link = what.partition("/")
        if name not in self._objects:
            yield f"what is '{what}'; {self._unknown(name)}, and {ROBOT} and {TOOL}"
            return
        model = self._objects[name].model
        links = [each.name for each in model.links]
        latched = [each.child for each in model.joints if each.motion is Motion.LATCH]
        if link and link not in (links[0], *latched):
            # Where the others are, their joints tell.
            known = ", ".join((links[0], *latched))
            yield f"what is '{what}'; of {name}, the truth has the poses of: {known}"
        elif model.static and link in ("", links[0]) and kind != "inside":
            yield f"what is '{what}', which stands fast; something that moves is needed"

    def _movable(self, name: str) -> Iterator[str]:
        if name not in self._objects:
            yield self._unknown(name)
        elif not self._objects[name].model.moving_links():
            yield f"object is '{name}', which stands fast; something that moves is needed"

    def _joint(self, name: str, joint: str, latch: bool) -> Iterator[str]:
        if name == ROBOT and not latch:
            return
        if name not in self._objects:
            yield self._unknown(name)
            return
        joints = [
            each.name
            for each in self._objects[name].model.joints
            if (each.motion is Motion.LATCH) == latch
        ]
        if joint not in joints:
            what = "latches" if latch else "joints"
            yield f"joint is '{joint}'; {name} has the {what}: {', '.join(joints) or 'none'}"

    def _unknown(self, name: str) -> str:
        return f"object is '{name}'; there are: {', '.join(self._objects) or 'none'}"

    def _names(self) -> Iterator[Finding]:
        exercise = self._exercise
        for group, thing in exercise.contacts.allowed:
            if group not in (ANY, *GROUPS):
                yield Finding(
                    "contacts/allowed",
                    f"group is '{group}'; {', '.join((ANY, *GROUPS))} are possible",
                )
            if thing not in (ANY, FLOOR, _ANOTHER_ROBOT, *self._objects):
                yield Finding("contacts/allowed", f"{self._unknown(thing)}, and {ANY}, {FLOOR}")
        for name in exercise.put_back.objects:
            if name not in (ALL, *self._objects):
                yield Finding("put_back/objects", f"{self._unknown(name)}, and {ALL}")
        if exercise.put_back != PutBack():
            yield Finding(
                "put_back", "this version puts everything back between repetitions", wrong=False
            )
        for metric in exercise.metrics:
            where = f"metrics/{metric.name}"
            if metric.bound is not None and round(metric.bound, DIGITS) != metric.bound:
                yield Finding(
                    f"{where}/pass",
                    f"it is {metric.bound:g}; figures are judged by their first {DIGITS} decimals",
                    wrong=False,
                )
            if metric.kind == "dose":
                continue
            if metric.object and metric.object not in (FLOOR, *self._objects):
                yield Finding(f"{where}/object", self._unknown(metric.object))
            timed = any(m.kind == "time" and m.expert is not None for m in exercise.metrics)
            if metric.kind == "proficiency" and not timed:
                yield Finding(where, "metrics/time/expert is missing: there is no expert's rate")
            if metric.kind in SURVEYED and exercise.survey is None:
                yield Finding(where, "survey is missing: there are no points to pass")
            if metric.kind == "answers" and not exercise.questions:
                yield Finding(where, "the exercise asks no questions")

    def _doses(self) -> Iterator[Finding]:
        """Doses are only told where something radiates, or has."""
        links = [link for item in self._scene.objects for link in item.model.links]
        if any(link.source is not None for link in links):
            return
        exercise = self._exercise
        without = "the scene has no source; `sources` puts one on an object"
        for where, condition in exercise.conditions():
            if any(part.kind == "dose" for part in condition.walk()):
                yield Finding(f"{where}/dose", without)
        for metric in exercise.metrics:
            if metric.kind == "dose":
                yield Finding(f"metrics/{metric.name}", without)

    def _start(self) -> Iterator[Finding]:
        """The clock must not begin before anybody has done anything."""
        begin, start = self._exercise.begin, self._scene.start
        place = (start.x, start.y, start.ground + _HEIGHT)
        inside = begin.parts[0] if begin.kind == "not" else begin
        if inside.kind != "inside" or inside.of.what != ROBOT:
            return
        zone = self._exercise.zones.get(inside.of.zone)
        if zone is None or zone.of:
            return
        if zone.contains(place) == (begin.kind == "inside"):
            yield Finding(
                "begin",
                f"it holds already where the robot starts, at {[round(x, 3) for x in place]}",
            )

    def _questions(self) -> Iterator[Finding]:
        for question in self._exercise.questions:
            where = f"questions ({question.name})"
            if question.of and question.of not in self._objects:
                yield Finding(f"{where}/of", self._unknown(question.of))
                continue
            if not question.of and not question.answer:
                yield Finding(
                    where, "neither of nor answer is given: nobody knows what is right", False
                )

    def _hints(self) -> Iterator[Finding]:
        exercise = self._exercise
        names: Set[str] = {"time", *EVENTS}
        for items in (exercise.steps, exercise.faults, exercise.penalties):
            names.update(item.name for item in items)
        for i, hint in enumerate(exercise.hints):
            if hint.on not in names:
                yield Finding(
                    f"hints[{i}]/on", f"it is '{hint.on}'; possible are {', '.join(sorted(names))}"
                )


def _beyond(content: Mapping[str, Any]) -> Iterator[Finding]:
    """Name what no operator has shown to be possible."""
    types = object_types()
    for entry in content["objects"]:
        kind = entry.get("type")
        if kind not in _SHOWN:
            continue
        key, shown = _SHOWN[kind]
        value = entry.get(key, getattr(types[kind], key, 0.0))
        if isinstance(value, (int, float)) and value > shown + 1e-6:
            yield Finding(
                f"scene ({entry.get('name', kind)})",
                f"{key} is {value:g}; beyond the robot's reach, which is shown up to {shown:g}",
                wrong=False,
            )


def _check_robot(exercise: Exercise, urdfs: Dict[str, str]) -> Iterator[Finding]:
    try:
        if exercise.variant not in urdfs:
            urdfs[exercise.variant] = robot_description(exercise.variant)
        lacks = list(lacking(exercise, urdfs[exercise.variant]))
    except ValueError as error:
        # The generator's own words, or those of who reads what it made.
        yield Finding("variant", str(error))
        return
    yield from _malfunctions(exercise, urdfs[exercise.variant], "", exercise.variant)
    for where, text in lacks:
        yield Finding(where, f"{text}, which the variant '{exercise.variant}' lacks")
    yield from _check_further(exercise, urdfs)
    seeds = {exercise.seeds.of(mode) for mode in MODES} - {None}
    if exercise.vary and exercise.setting == exercise.settings[0]:
        # What a seed moves is the same in all settings; each try takes a second.
        seeds.update(_OTHER_SEEDS)
    texts = {scene_text(exercise, seed): seed for seed in seeds if seed is not None}
    problem = _room({seed: text for text, seed in texts.items()}, exercise.variant)
    if problem:
        yield Finding("scene", problem)


def _check_further(exercise: Exercise, urdfs: Dict[str, str]) -> Iterator[Finding]:
    for i, robot in enumerate(exercise.robots):
        variant = robot.variant or exercise.variant
        try:
            if variant not in urdfs:
                urdfs[variant] = robot_description(variant)
            for where, text in lacking(exercise, urdfs[variant], robot.name):
                yield Finding(where, f"{text}, which the variant '{variant}' lacks")
            yield from _malfunctions(exercise, urdfs[variant], robot.name, variant)
        except ValueError as error:
            yield Finding(f"robots[{i}]/variant", str(error))


def _malfunctions(exercise: Exercise, urdf: str, of: str, variant: str) -> Iterator[Finding]:
    """Name malfunctions that one of the robots cannot have, and what is possible."""
    parts = described_parts(urdf) if exercise.malfunctions else Parts()
    for i, malfunction in enumerate(exercise.malfunctions):
        failure = malfunction.failure
        if failure.robot != of:
            continue
        try:
            parts.find(failure.what, failure.kind).kind.severity(failure.value)
        except ConfigError as error:
            yield Finding(f"malfunctions[{i}]", f"{error} (variant '{variant}')")


def _room(texts: Dict[int, str], variant: str) -> str:
    """Put the robot into scenes by their seeds; returns what is in the way, empty: nothing."""
    script = Path(package_path("telex_sim"), "nodes", "scene")
    with tempfile.TemporaryDirectory() as folder:
        paths = {seed: Path(folder, f"seed_{seed}.yaml") for seed in texts}
        for seed, path in paths.items():
            path.write_text(texts[seed], encoding="utf-8")
        command = [str(script), "check", f"--variant={variant}", *map(str, paths.values())]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if not done.returncode:
            return ""
        said = " ".join(done.stderr.split()) or f"scene check ended with {done.returncode}"
        for seed, path in paths.items():
            said = said.replace(str(path), f"with seed {seed}")
        return said
