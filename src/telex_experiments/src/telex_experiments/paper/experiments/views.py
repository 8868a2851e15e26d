"""Figures 6 and 11: the console, and what the six cameras see."""

from __future__ import annotations

import itertools
import math
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Dict, List, Sequence, Tuple

import cv2
import numpy as np
import rospy
import yaml
from geometry_msgs.msg import PoseStamped
from sensor_msgs.msg import CameraInfo
from telex_msgs.msg import ScenePoses
from telex_msgs.srv import Delete, Spawn

from telex_control.common.geometry.matrices import pose_matrices

from ...rigs.chromium import lacking
from ..console import opened
from ..experiment import Cell, Experiment, Figure, ReportPicture, ReportTable, Result
from ..session import PaperSession

CONSOLE_SIZE = (1280, 720)  # px
DRIVE_TIME = 2.0  # s, for which the console's key is held
LEAST_CONTRAST = 12.0
"""Standard deviation of the grey levels of a picture that shows something."""
LEAST_DIFFERENCE = 8.0
"""Mean difference of the grey levels of two views, small, that are not the same."""
MARKER = "paper_marker"
MAGENTA = (1.0, 0.0, 1.0, 1.0)
"""Of the ball that is put before the cameras: nothing else in the hall has that colour."""
MOST_ASIDE = 3.0
"""Of the ball's picture from where the model says it is (px)."""
LEAST_AREA, MOST_AREA = 0.7, 1.3
"""Of the ball's picture, as a share of what the model says."""
CELL, CAPTION, GAP = (480, 360), 26, 6  # px
INK, PAPER = (40, 30, 25), (255, 255, 255)


@dataclass(frozen=True)
class CameraView:
    """A camera, and where the ball is put before it.

    Attributes
    ----------
    distance, radius : float
        Of the ball on the camera's axis (m).
    """

    camera: str
    distance: float
    radius: float


@dataclass(frozen=True)
class Spot:
    """The ball, as a camera has seen it.

    Attributes
    ----------
    aside : float
        Distance from where the model says it is to be seen (px); infinite if it is not seen.
    area : float
        As a share of what the model says.
    picture : array, shape (height, width, 3)
        RGB.
    """

    aside: float
    area: float
    picture: np.ndarray


VIEWS = (
    # Near enough to be above the floor, which these two look down to.
    CameraView("front", 0.5, 0.03),
    CameraView("rear", 0.5, 0.03),
    # Before the arm's joints, and before the closed fingers, which would hide it.
    CameraView("arm", 0.16, 0.010),
    CameraView("gripper", 0.10, 0.007),
    CameraView("turret", 1.0, 0.04),
    CameraView("mast", 0.40, 0.025),
)


def grey(picture: np.ndarray) -> np.ndarray:
    """Return a picture's grey levels."""
    return cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY).astype(float)


def contrast(picture: np.ndarray) -> float:
    """Return the standard deviation of a picture's grey levels (of 255)."""
    return float(grey(picture).std())


def difference(one: np.ndarray, other: np.ndarray) -> float:
    """Return the mean difference of two pictures' grey levels, seen small (of 255)."""
    small = [
        cv2.resize(grey(each), (64, 48), interpolation=cv2.INTER_AREA) for each in (one, other)
    ]
    return float(np.abs(small[0] - small[1]).mean())


def magenta(picture: np.ndarray) -> Tuple[int, Tuple[float, float]]:
    """Return of a picture's magenta dots their number and their middle (x, y; px)."""
    red, green, blue = (picture[..., channel].astype(int) for channel in range(3))
    found = (red > 1.6 * green + 20) & (blue > 1.6 * green + 20)
    rows, columns = np.nonzero(found)
    if not len(rows):
        return 0, (math.nan, math.nan)
    return len(rows), (float(columns.mean()), float(rows.mean()))


def spot(session: PaperSession, view: CameraView, frames: Sequence[str]) -> Spot:
    """Put a ball on a camera's axis, and look whether it is seen where the model says."""
    namespace = session.namespace
    poses = np.array(session.wait_for("sim/poses", ScenePoses).poses).reshape(-1, 7)
    info = session.wait_for(f"cameras/{view.camera}/camera_info", CameraInfo)
    # Of the camera's frame as pictures have it, of the model as the scene has it.
    flat = poses[frames.index(f"telex/{info.header.frame_id}")]
    (camera,) = pose_matrices(flat[None])
    place = camera[:3, 3] + view.distance * camera[:3, 2]
    ball = {
        "type": "custom",
        "position": [float(value) for value in place],
        "static": True,
        "links": [
            {
                "name": "ball",
                "parts": [
                    {
                        "sphere": view.radius,
                        "solid": False,
                        "surface": {"color": list(MAGENTA)},
                    }
                ],
            }
        ],
    }
    spawn = rospy.ServiceProxy(f"{namespace}/sim/spawn", Spawn)
    answer = spawn(MARKER, yaml.safe_dump(ball), "")
    if not answer.success:
        raise RuntimeError(f"sim/spawn: {answer.message}")
    try:
        # The renderer learns of it before the poses do, and exposes the next pictures.
        rospy.sleep(0.6)
        picture = session.look(view.camera)
    finally:
        rospy.ServiceProxy(f"{namespace}/sim/delete", Delete)(MARKER)
    number, (x, y) = magenta(picture)
    expected = math.pi * (info.K[0] * view.radius / view.distance) ** 2
    # Distortion leaves the principal point alone; camera_info tells where it is.
    aside = math.hypot(x - info.K[2], y - info.K[5])
    return Spot(math.inf if math.isnan(aside) else aside, number / expected, picture)


def sheet(pictures: Dict[str, np.ndarray]) -> np.ndarray:
    """Return views side by side, each with its name (RGB)."""
    cells = []
    for name, picture in pictures.items():
        cell = np.full((CELL[1] + CAPTION, CELL[0] + GAP, 3), PAPER, dtype=np.uint8)
        cell[: CELL[1], : CELL[0]] = cv2.resize(picture, CELL, interpolation=cv2.INTER_AREA)
        at = (6, CELL[1] + CAPTION - 8)
        cv2.putText(cell, name, at, cv2.FONT_HERSHEY_SIMPLEX, 0.55, INK, 1, cv2.LINE_AA)
        cells.append(cell)
    rows = [np.hstack(cells[start : start + 3]) for start in range(0, len(cells), 3)]
    return np.vstack(rows)


def write_jpeg(path: Path, picture: np.ndarray) -> None:
    """Write an RGB picture."""
    cv2.imwrite(str(path), picture[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 85])


def look_around(session: PaperSession) -> Result:
    """Take the six views, and check what is in them."""
    with session.simulator(world="training_hall", pose="look_front", console=False):
        names = [view.camera for view in VIEWS]
        with session.record("views", cameras=names, rate=2.0):
            pictures = {name: session.look(name) for name in names}
            overview = session.look("overview")
            frames = list(session.scene().frames)
            spots = {}
            for view in VIEWS:
                session.say(f"a ball before the camera {view.camera}")
                spots[view.camera] = spot(session, view, frames)
    write_jpeg(session.folder / "cameras.jpg", sheet(pictures))
    balls = {name: found.picture for name, found in spots.items()}
    write_jpeg(session.folder / "balls.jpg", sheet(balls))
    write_jpeg(session.folder / "overview.jpg", overview)
    contrasts = {name: contrast(picture) for name, picture in pictures.items()}
    least = min(
        difference(pictures[one], pictures[other])
        for one, other in itertools.combinations(pictures, 2)
    )
    areas = [found.area for found in spots.values()]
    rows: List[List[Cell]] = [
        [name, *picture.shape[1::-1], contrasts[name], spots[name].aside, spots[name].area]
        for name, picture in pictures.items()
    ]
    return Result(
        figures=[
            Figure("views", len(pictures), "", at_least=6),
            Figure(
                "least contrast of a view",
                min(contrasts.values()),
                "grey levels",
                at_least=LEAST_CONTRAST,
            ),
            Figure(
                "least difference of two views", least, "grey levels", at_least=LEAST_DIFFERENCE
            ),
            Figure(
                "ball aside of where it is to be seen, worst",
                max(found.aside for found in spots.values()),
                "px",
                at_most=MOST_ASIDE,
            ),
            Figure("ball's area over the expected, smallest", min(areas), "", at_least=LEAST_AREA),
            Figure("ball's area over the expected, largest", max(areas), "", at_most=MOST_AREA),
        ],
        pictures=[
            ReportPicture(
                "What the six cameras see.",
                "cameras.jpg",
                "At the start in the training hall; the operator has nothing else to go by.",
                wide=True,
            ),
            ReportPicture(
                "The simulation in use.",
                "overview.jpg",
                "The instructor's camera, which operators are not shown.",
            ),
            ReportPicture(
                "A ball on each camera's axis.",
                "balls.jpg",
                "Where the model of the robot says that the lens looks, and as large.",
                wide=True,
            ),
        ],
        tables=[
            ReportTable(
                "Views",
                "views.csv",
                ("camera", "width px", "height px", "contrast", "ball aside px", "area / expected"),
                rows,
                "A magenta ball was put on each camera's axis, by the poses of the running "
                "physics; it must be seen in the middle of the lens, as large as it has to be.",
            )
        ],
        bags=["views.bag"],
    )


def _place(session: PaperSession) -> np.ndarray:
    position = session.wait_for("sim/base_pose", PoseStamped).pose.position
    return np.array([position.x, position.y])


def sit_at_the_console(session: PaperSession) -> Result:
    """Open the console, hold a key, and take its picture while the robot drives."""
    problem = lacking()
    if problem:
        return Result(error=problem)
    with session.simulator(world="training_hall", pose="look_front") as simulator:
        assert simulator.video_url is not None
        with opened(f"{simulator.video_url}/", CONSOLE_SIZE) as console, session.record(
            "console", cameras=("front",), watched=True
        ):
            console.wait_until_live()
            session.say("the console is live; holding W")
            before = _place(session)
            with console.hold("KeyW"):
                time.sleep(DRIVE_TIME)
                png = console.browser.screenshot()
                live = sum(state for _, state in console.thumbnails())
                linked = console.is_linked()
            rospy.sleep(0.5)
            driven = float(np.linalg.norm(_place(session) - before))
    page = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)[..., ::-1]
    write_jpeg(session.folder / "console.jpg", page)
    return Result(
        figures=[
            Figure("connected to the robot", float(linked), "", at_least=1),
            Figure("live views beside the large one", live, "", at_least=5),
            Figure("driven by the key W", driven, "m", at_least=0.1),
            Figure("contrast of the page", contrast(page), "grey levels", at_least=LEAST_CONTRAST),
        ],
        pictures=[
            ReportPicture(
                "The console in a browser.",
                "console.jpg",
                "While the key W is held: the robot drives, all cameras are live.",
                wide=True,
            )
        ],
        bags=["console.bag"],
    )


EXPERIMENTS = (
    Experiment(
        name="fig6_console",
        paper="Figure 6, section 4.4",
        title="The operator's console",
        claim="A GUI is interfaced with the simulator; the user drives by keyboard or joystick and "
        "sees only what the robot's cameras show.",
        method="The console is opened in headless Chromium, the key W is held as an operator "
        "would, and the page is photographed meanwhile. Ground truth tells that the robot drove.",
        bar="present: connected, six live cameras, the robot obeys the key",
        run=sit_at_the_console,
        seconds=55.0,
        quick_seconds=55.0,
        # A browser, six cameras and the physics are all that two cores can do at once.
        alone=True,
        groups=("fig6",),
    ),
    Experiment(
        name="fig11_cameras",
        paper="Figure 11, section 4.4",
        title="What the six cameras see",
        claim="Figure 11 gives a complete picture of the simulation in use: the robot in its "
        "environment, and the visual feedback of its on-board cameras.",
        method="A picture of each camera in the training hall. For the content, a ball is put on "
        "each camera's axis, and looked for in its picture.",
        bar="six views, not flat, no two alike; a ball on the axis seen within 3 px",
        run=look_around,
        seconds=45.0,
        quick_seconds=45.0,
        groups=("fig11",),
    ),
)
