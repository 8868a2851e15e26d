"""``rosrun telex_sim scene``: checks, lists, shows and explains scenes; needs no ROS master."""

from __future__ import annotations

import argparse
import sys
import textwrap
from pathlib import Path
from typing import Callable, List, Optional, Sequence

from telex_control.common.params import ConfigError
from telex_control.urdf.joints import UrdfError

from .assets import Assets
from .catalog import PATH_VARIABLE, find_scene, scenes
from .files.scene_file import SceneError, load_scene
from .library import object_types
from .model import Scene
from .planning import plan_scene
from .type_texts import parameters, summary

_WIDTH = 100


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run a command; returns the exit status."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    if words[:1] == ["preview"]:
        # Drawing takes a graphics library, which the other commands do without.
        from ..cameras.preview.scene_preview import main as preview

        return preview(words[1:])
    if words[:1] == ["pictures"]:
        from ..cameras.preview.object_pictures import main as pictures

        return pictures(words[1:])
    options = _parser().parse_args(words)
    try:
        return options.run(options)
    except (ConfigError, SceneError) as error:
        print(error, file=sys.stderr)
        return 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="scene",
        description="Scenes of the simulator; docs/instructor/scenes.md describes their files.",
        epilog=f"Scenes are also found by name in the folders of {PATH_VARIABLE} (separated by :).",
    )
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    check = commands.add_parser("check", help="say whether scene files are right")
    check.add_argument("scenes", nargs="+", metavar="FILE", help="file, or name of a scene")
    check.add_argument(
        "--pose", default="", metavar="NAME", help="of the robot; default: the scene's"
    )
    check.add_argument(
        "--variant", default="standard", metavar="NAME", help="of the robot: a name, or its file"
    )
    check.add_argument(
        "--no-robot", action="store_true", help="leave out whether the robot has room at its start"
    )
    check.set_defaults(run=_check)
    listing = commands.add_parser("list", help="list the scenes that have a name")
    listing.set_defaults(run=_list)
    types = commands.add_parser("types", help="list the types of objects, or explain some")
    types.add_argument("types", nargs="*", metavar="TYPE")
    types.set_defaults(run=_types)
    commands.add_parser("preview", help="draw a picture of a scene (see: scene preview --help)")
    commands.add_parser("pictures", help="draw a small picture of each type of object, for lists")
    return parser


def _check(options: argparse.Namespace) -> int:
    checked = _without_robot() if options.no_robot else _with_robot(options)
    wrong = 0
    for world in options.scenes:
        try:
            path = find_scene(world)
            print(f"{path}: OK, {counts(checked(path))}")
        except SceneError as error:
            print(error, file=sys.stderr)
            wrong += 1
    return 1 if wrong else 0


def _without_robot() -> Callable[[Path], Scene]:
    # Physics takes a moment to load, which the other commands do without.
    from ..offline.simulation import shipped_config
    from ..rehearsal.trial import Rehearsal

    config = shipped_config()

    def check(path: Path) -> Scene:
        planned = plan_scene(path, Assets(), config.timing.step_size)
        with Rehearsal(config, str) as rehearsal:
            rehearsal.scene(planned, ())
        return planned.scene

    return check


def _with_robot(options: argparse.Namespace) -> Callable[[Path], Scene]:
    from ..engine.world import WorldError
    from .robot_in_scene import place_robot, robot_description

    urdf = robot_description(options.variant)

    def check(path: Path) -> Scene:
        try:
            simulation = place_robot(path, urdf, options.pose)
        except (ConfigError, UrdfError, WorldError) as error:
            raise SceneError(str(error)) from error
        simulation.close()
        return simulation.scene

    return check


def counts(scene: Scene) -> str:
    """How much there is in a scene, in words."""
    static = sum(item.model.static for item in scene.objects)
    joints = sum(len(item.model.joints) for item in scene.objects)
    words = [f"{static} static and {len(scene.objects) - static} movable objects"]
    if joints:
        words.append(f"{joints} joints")
    if scene.lights.lamps:
        words.append(f"{len(scene.lights.lamps)} lamps")
    return ", ".join(words)


def _list(options: argparse.Namespace) -> int:
    wrong = 0
    for name, path in scenes().items():
        print(name)
        try:
            scene = load_scene(path)
        except SceneError as error:
            wrong += 1
            print(_indented(f"broken: {error}"))
            continue
        if scene.description:
            print(_indented(scene.description))
        print(_indented(counts(scene)))
        print(_indented(str(path)))
    return 1 if wrong else 0


def _types(options: argparse.Namespace) -> int:
    types = object_types()
    unknown = [name for name in options.types if name not in types]
    if unknown:
        print(f"there is no type '{unknown[0]}'; there are: {', '.join(types)}", file=sys.stderr)
        return 1
    if not options.types:
        width = max(map(len, types))
        for name, kind in types.items():
            print(f"{name:{width}}  {summary(kind)}")
        return 0
    for name in options.types:
        print(f"{name}: {summary(types[name])}")
        lines: List[str] = []
        for parameter, default, meaning in parameters(types[name]):
            lines += [f"  {parameter}: {default}", _indented(meaning, 6)]
        print("\n".join(line for line in lines if line.strip()))
    return 0


def _indented(text: str, indent: int = 4) -> str:
    margin = " " * indent
    return textwrap.fill(
        text,
        _WIDTH,
        initial_indent=margin,
        subsequent_indent=margin,
        # A path in two parts could not be copied.
        break_long_words=False,
        break_on_hyphens=False,
    )
