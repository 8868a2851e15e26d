"""Scripted operators: figures 9 and 10 of the paper, through the robot's ROS interface alone.

They command by the teleoperation nodes' topics and services, as console and joystick do, and see
joint states. Ground truth tells them where the base is, and where pallet and briefcase stand, as
somebody would who stands beside; the cube is found in the cameras' pictures alone.
"""

from __future__ import annotations

from telex_training.operators.tasks.briefcase import Briefcase
from telex_training.operators.tasks.cube import CubeToBox
from telex_training.operators.tasks.pallet import PalletSide

from ..experiment import Experiment, Result
from ..session import PaperSession
from .runs import TaskRuns, drive_course

_HANDS = (
    "A script commands as console and joystick do: track_teleop/cmd_vel, flipper presets, "
    "arm_teleop/named_pose_cmds and pose_cmds (straight lines), gripper_teleop."
)
_RUN = (
    "Before each run the scene is reset and the objects are put down anew, at a place and heading "
    "drawn with the seed. What became of it is judged by the objects' true poses."
)
_CLAIM_9 = "Objects of different weights and shapes were grasped, "
_BAR_9 = "done in at least 9 of 10 runs"


def _pallet(session: PaperSession) -> Result:
    return TaskRuns(session, PalletSide, ("gripper",), 2.5).carry_out()


def _briefcase(session: PaperSession) -> Result:
    return TaskRuns(session, Briefcase, ("front",), 2.5).carry_out()


def _cube(session: PaperSession) -> Result:
    return TaskRuns(session, CubeToBox, ("gripper", "turret"), 1.5, looks=True).carry_out()


EXPERIMENTS = (
    Experiment(
        name="fig9_pallet",
        paper="figure 9, section 5",
        title="Lifting a pallet's side",
        claim=_CLAIM_9 + "such as a pallet (figure 9).",
        method=f"{_HANDS} Base, pallet and joints are seen by ground truth and joint states; the "
        "grip's force is that which the console displays. The pallet (25 kg) is gripped by the "
        f"boards of its end, and this is lifted by 15 cm and held for 2 s. {_RUN}",
        bar=f"the end stays 12 cm up or more, the other on the floor; {_BAR_9}",
        run=_pallet,
        seconds=150.0,
        quick_seconds=60.0,
        groups=("fig9",),
    ),
    Experiment(
        name="fig9_briefcase",
        paper="figure 9, section 5",
        title="Grasping and carrying a briefcase",
        claim=_CLAIM_9 + "which included grasping and carrying around a briefcase.",
        method=f"{_HANDS} Base, case and joints are seen by ground truth and joint states; the "
        "grip's force is that which the console displays. The case (5 kg) is gripped by the bar "
        f"of its handle, lifted, and carried 3 m at 0.5 m/s. {_RUN}",
        bar=f"3 m or more away, upright, 5 cm or more off the floor; {_BAR_9}",
        run=_briefcase,
        seconds=170.0,
        quick_seconds=60.0,
        groups=("fig9",),
    ),
    Experiment(
        name="fig9_cube",
        paper="section 5",
        title="A small cube from one box into another, by the cameras alone",
        claim=_CLAIM_9 + "which included grabbing a small cube from one box and placing it into "
        "another one by using only visual feedback from the on-board cameras.",
        method=f"{_HANDS} The boxes are found by their colours in the turret camera's compressed "
        "pictures, the cube (5 cm) by its colour and outline in the gripper camera's, with "
        "camera_info and the joint states; known are the heights of table and boxes, and the "
        "sizes. The grip is felt by the fingers' joints; after lifting, the picture tells whether "
        "the cube came along, and in the end whether it lies in the other box. Ground truth of "
        f"the base serves as odometry; none of boxes and cube is looked at. {_RUN}",
        bar=f"the cube lies in the other box, which stands; {_BAR_9}",
        run=_cube,
        seconds=330.0,
        quick_seconds=90.0,
        groups=("fig9",),
    ),
    Experiment(
        name="fig10_course",
        paper="figure 10, section 5",
        title="Maze, obstacles, stairs, and 50 cm by the flippers",
        claim="The operator drove the robot around a maze and made it climb different obstacles. "
        "By controlling the flippers, Telemax climbed up to 50 cm.",
        method="A script drives by track_teleop/cmd_vel, and by flipper keys and presets, as "
        "console and joystick do; it looks at ground truth of the base, as somebody who stands "
        "beside. One way through a maze, over a ramp of 40 cm and a barrier of 30 cm, up and down "
        "six steps of 17 x 28 cm, and up a step of 50 cm, without a stop between. The maze's plan "
        "and the places of the obstacles are known.",
        bar="every section done, each with its filmstrip",
        run=drive_course,
        seconds=170.0,
        quick_seconds=170.0,
        groups=("fig10",),
    ),
)
