"""Steps joints through their controllers' topics, and shows how they respond.

Works on a simulator that runs. The robot is moved: into each posture, one joint after the other,
and back. Writes figures (PNG, SVG) and a table (Markdown, CSV, JSON; SI units).
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any, List, Optional, Sequence

import yaml

from ..command_lines import program
from ..common.file_catalog import package_path
from ..common.params import ConfigError
from ..common.yaml_files import load_yaml
from . import report, table
from .plan import CURRENT, Plan
from .ros_session import RosRig, find_namespace, require_running
from .runner import Runner, StepError, StepResult


def default_plan() -> Path:
    """Path of the shipped ``step_response.yaml``."""
    return Path(package_path("telex_control")) / "config" / "step_response.yaml"


def read_plan(path: Path) -> Plan:
    """Read a plan, and the named poses of telex_description that it refers to.

    Raises
    ------
    ConfigError
        A file cannot be read or is wrong; the message names it.
    """
    poses = Path(package_path("telex_description")) / "config" / "poses.yaml"
    try:
        return Plan(_yaml(path), _yaml(poses)["poses"])
    except (OSError, yaml.YAMLError, ConfigError) as error:
        raise ConfigError(f"{path}: {error}") from error


def _yaml(path: Path) -> Any:
    with open(path, encoding="utf-8") as file:
        return load_yaml(file)


def _size(text: str) -> float:
    value = float(text)
    if not 0.0 < value < 180.0:
        raise argparse.ArgumentTypeError(f"{text} is not between 0 and 180")
    return value


def parse(arguments: Sequence[str]) -> argparse.Namespace:
    """Read the command line; it ends the program when that is wrong."""
    parser = argparse.ArgumentParser(prog="step_response", description=__doc__)
    parser.add_argument(
        "joints", nargs="*", metavar="JOINT", help="joints or groups: arm, fingers, flippers"
    )
    parser.add_argument("--all", action="store_true", help="all groups")
    parser.add_argument(
        "--pose",
        nargs="+",
        default=None,
        metavar="POSE",
        help=f"folded, stretched (both are the default), or {CURRENT}: where the robot is",
    )
    parser.add_argument(
        "--step", type=_size, metavar="SIZE", help="of the steps: degrees, mm (15, and 50 mm)"
    )
    parser.add_argument(
        "--no-raw",
        action="store_true",
        help="leave out the steps that the controllers follow without limits and filter",
    )
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("results") / "step_response",
        metavar="DIR",
        help="folder for figures and tables (results/step_response)",
    )
    parser.add_argument("--namespace", metavar="NS", help="of the robot, where there are several")
    parser.add_argument(
        "--plan", type=Path, metavar="FILE", help="in place of config/step_response.yaml"
    )
    options = parser.parse_args(list(arguments))
    if options.all == bool(options.joints):
        parser.error("name joints or groups, or say --all")
    return options


def measure(options: argparse.Namespace, plan: Plan) -> List[StepResult]:
    """Carry out the measurement; what was measured is written also when it breaks off.

    Raises
    ------
    StepError
    """
    postures: List[str] = options.pose or plan.postures()
    for posture in postures:
        if posture not in (*plan.postures(), CURRENT):
            raise StepError(f"--pose {posture}: there are {', '.join((*plan.postures(), CURRENT))}")
    namespace: Optional[str] = options.namespace
    rig = RosRig(find_namespace() if namespace is None else namespace.rstrip("/"))
    described = rig.joints()
    if options.all:
        # A variant of the robot may lack some of them.
        names = [joint for joint in plan.select([]) if joint in described]
    else:
        names = plan.select(options.joints)
        require_running(names, list(described))
    runner = Runner(rig, plan, described, lambda line: print(line, flush=True))
    results: List[StepResult] = []
    try:
        kinds = (False,) if options.no_raw else (False, True)
        for result in runner.run(postures, names, kinds, options.step):
            results.append(result)
    finally:
        if results:
            print("\n" + table.text(results))
            for path in report.write(options.out, plan, results):
                print(path)
    return results


def main() -> None:
    """Run the program."""
    options = parse(program.arguments())

    def work() -> None:
        plan = read_plan(options.plan or default_plan())
        program.begin_measurement("step_response")
        measure(options, plan)

    program.run_measurement("step_response", work, ConfigError, StepError)
