"""Cost of a picture of a recorded scene: no ROS is needed, and no simulator.

`record` makes the recording anew, with both.
"""

from __future__ import annotations

import dataclasses
import functools
import json
import statistics
import time
from pathlib import Path
from typing import Any, Dict, List, NamedTuple, Union

import cv2
import numpy as np
import simplejpeg

from telex_experiments.rigs.report import Figure
from telex_sim.cameras.cameras_config import shipped_cameras
from telex_sim.cameras.drawing.gl_context import create_context
from telex_sim.cameras.drawing.light.daylight import Lighting
from telex_sim.cameras.drawing.quality import choose_quality, is_card
from telex_sim.cameras.drawing.renderer import Renderer
from telex_sim.cameras.optics.camera_sensor import CameraSensor
from telex_sim.cameras.optics.exposure import ExposureControl, exposure_factor
from telex_sim.cameras.optics.lens import bending_threads
from telex_sim.cameras.optics.pinhole import PinholeCamera
from telex_sim.cameras.ros.size_by_load import STEPS, SizeStep
from telex_sim.scene.visual_scene import Daylight, Visual, VisualLamp, VisualScene, VisualShape

from ..workspace import ROOT
from .bare_picture import BarePicture

WORLD = "training_hall"
NAMES = ("front", "rear", "arm", "gripper", "turret", "mast")
LARGE = {"width": 640, "height": 480}
SMALL = {"width": 320, "height": 240}
MAIN = {"width": 1280, "height": 720}
RECORDING = Path(__file__).with_name(f"{WORLD}.npz")
PACKAGES = ROOT / "src"
QUALITY = 80
"""Of JPEG, as the node's."""
LEAST_RATIO = 5.0
"""How many pictures with JPEG must cost less than a bare getCameraImage."""


def package_path(name: str) -> str:
    """Folder of one of this repository's packages."""
    return str(PACKAGES / name)


class RecordedScene(NamedTuple):
    """A scene with the robot at rest.

    Attributes
    ----------
    model : str
        Name of the robot in it.
    frames_in_world : ndarray, shape (frames, 4, 4)
    """

    scene: VisualScene
    model: str
    frames_in_world: np.ndarray

    def camera(self, name: str) -> np.ndarray:
        """Pose of a camera's optical frame, shape (4, 4)."""
        index = self.scene.frames.index(f"{self.model}/{name}_camera_optical_frame")
        return self.frames_in_world[index]


def record(path: Path = RECORDING) -> None:
    """Write the recording."""
    from telex_sim.cameras.preview.scene_preview import settled

    subject = settled(WORLD)
    scene = json.dumps({"model": subject.model, **dataclasses.asdict(subject.scene)})
    np.savez_compressed(path, scene=scene, frames_in_world=subject.frames_in_world)


@functools.lru_cache(maxsize=None)
def hall() -> RecordedScene:
    """Read the recording."""
    with np.load(RECORDING) as file:
        content, frames_in_world = json.loads(str(file["scene"])), file["frames_in_world"]
    model = content.pop("model")
    content["frames"] = tuple(content["frames"])
    content["visuals"] = tuple(
        Visual(**{**_tuples(each), "shape": VisualShape(each["shape"])})
        for each in content["visuals"]
    )
    content["lamps"] = tuple(VisualLamp(**_tuples(each)) for each in content["lamps"])
    content["daylight"] = Daylight(**_tuples(content["daylight"]))
    return RecordedScene(VisualScene(**content), model, frames_in_world)


def _tuples(content: Dict[str, Any]) -> Dict[str, Any]:
    return {
        name: tuple(value) if isinstance(value, list) else value for name, value in content.items()
    }


@functools.lru_cache(maxsize=None)
def bare_picture() -> BarePicture:
    """The front camera's 640x480; the one of this process, and of those that are forked from it."""
    recording = hall()
    camera = PinholeCamera(LARGE["width"], LARGE["height"], 1.5, 0.05, 100.0)
    return BarePicture(
        recording.scene, recording.frames_in_world, camera, recording.camera("front"), package_path
    )


class Cost(NamedTuple):
    """What a picture costs (s): CPU time and wall time with its JPEG; the JPEG alone, wall time."""

    cpu: float
    wall: float
    encoding: float


class RobotViews:
    """Some cameras of the recorded robot, which moves between rounds.

    Parameters
    ----------
    size : dict
        Width and height (pixels).
    step : SizeStep
        How far these pictures give way, as if they were previews.
    """

    def __init__(self, names: tuple, size: Dict[str, int], step: SizeStep = STEPS[0]) -> None:
        recording = self._recording = hall()
        self._coarse = step.coarse_previews
        config = shipped_cameras()
        self._views = []
        for name in names:
            camera = config.cameras[name]
            camera = dataclasses.replace(
                camera,
                detail=step.preview_detail * camera.detail,
                width=size["width"],
                height=size["height"],
            )
            sensor = CameraSensor(camera, 1.0, 0, ExposureControl())
            self._views.append((sensor, recording.camera(name)))
        robot = [frame.startswith(f"{recording.model}/") for frame in recording.scene.frames]
        # So that its shadows have to be cast anew.
        self._frames = [recording.frames_in_world, recording.frames_in_world.copy()]
        self._frames[1][np.array(robot), 2, 3] += 0.001

    def __len__(self) -> int:
        """How many views there are."""
        return len(self._views)

    def load(self, renderer: Renderer) -> None:
        """Show the scene with a renderer."""
        renderer.load_scene(self._recording.scene)
        self.round(renderer, 0)

    def round(self, renderer: Union[Renderer, OnCard], number: int) -> Cost:
        """Take a picture of each view at new poses; the mean of what they cost."""
        focus = np.mean([pose[:3, 3] for _, pose in self._views], axis=0)
        cpu, began, encoding = time.process_time(), time.perf_counter(), 0.0
        renderer.place(self._frames[number % 2], focus)
        for sensor, pose in self._views:
            ev = sensor.expose(number)
            seen = renderer.render(sensor.pinhole, pose, exposure_factor(ev), self._coarse)
            picture = sensor.develop([seen], renderer.repeats, ev, number)
            taken = time.perf_counter()
            simplejpeg.encode_jpeg(
                picture, QUALITY, colorspace="RGBA", colorsubsampling="420", fastdct=True
            )
            encoding += time.perf_counter() - taken
        used = time.process_time() - cpu, time.perf_counter() - began, encoding
        return Cost(*(each / len(self._views) for each in used))


def told(figures: List[Figure]) -> List[Figure]:
    """Print figures as soon as they are there."""
    for figure in figures:
        print(f"  {figure.name}: {figure.value:.4g} {figure.unit}", flush=True)
    return figures


def renderer_figures(rounds: int) -> List[Figure]:
    """Cost of a picture, beside that of a bare getCameraImage between the rounds."""
    views = RobotViews(NAMES, LARGE)
    context = create_context()
    quality = choose_quality("auto", context.info["GL_RENDERER"])
    renderer = Renderer(context, quality, Lighting(), package_path)
    # As the node does.
    cv2.setNumThreads(bending_threads(is_card(context.info["GL_RENDERER"])))
    views.load(renderer)
    costs: List[Cost] = []
    bare: List[float] = []
    for number in range(1, rounds + 1):
        costs.append(views.round(renderer, number))
        bare.append(bare_picture().cost())
        print(f"  {number} of {rounds} rounds", flush=True)
    cpu, other = statistics.median(cost.cpu for cost in costs), statistics.median(bare)
    figures = [
        Figure("640x480 with JPEG, mean of six views: CPU", cpu * 1e3, "ms"),
        Figure("bare getCameraImage: CPU", other * 1e3, "ms"),
        Figure("bare getCameraImage / picture", other / cpu, "times", at_least=LEAST_RATIO),
    ]
    figures += giving_way(renderer, rounds)
    views.load(renderer)
    figures += timed("six 640x480", views, renderer, context, rounds, 30.0)
    main = RobotViews(NAMES[:1], MAIN)
    main.load(renderer)
    figures += timed("1280x720", main, renderer, context, rounds, 60.0)
    renderer.release()
    print(f"  OpenGL: {context.info['GL_RENDERER']}", flush=True)
    return told(figures)


def giving_way(renderer: Renderer, rounds: int) -> List[Figure]:
    """Cost of previews as they are set, and of those that give way to load, in turn."""
    plain, coarse = (RobotViews(NAMES[1:], SMALL, step) for step in STEPS[:2])
    for views in (plain, coarse):
        views.load(renderer)
        views.round(renderer, 1)
    costs = []
    for number in range(2, 4 * rounds + 2):
        costs.append([views.round(renderer, number).cpu for views in (plain, coarse)])
    before, after = np.median(costs, axis=0).tolist()
    return [
        Figure("five 320x240 with JPEG, mean: CPU", before * 1e3, "ms"),
        Figure("five 320x240 that give way, mean: CPU", after * 1e3, "ms"),
        Figure("five 320x240: as set / giving way", before / after, "times", at_least=1.2),
    ]


class OnCard:
    """A renderer whose pictures are timed on the graphics card.

    Attributes
    ----------
    spent : float
        On all pictures so far (s).
    repeats : bool
        As `Renderer` has it.
    """

    def __init__(self, renderer: Renderer, context: Any) -> None:
        self._renderer = renderer
        self.repeats = False
        self._query = context.query(time=True)
        self.spent = 0.0

    def place(self, *arguments: Any) -> None:
        """See `Renderer`."""
        self._renderer.place(*arguments)

    def render(self, *arguments: Any) -> np.ndarray:
        """See `Renderer`."""
        with self._query:
            picture = self._renderer.render(*arguments)
        self.spent += 1e-9 * self._query.elapsed
        self.repeats = self._renderer.repeats
        return picture


def timed(
    name: str, views: RobotViews, renderer: Renderer, context: Any, rounds: int, rate: float
) -> List[Figure]:
    """Time each picture on the graphics card, in all, and its encoding.

    Parameters
    ----------
    rate
        That drawing and encoding alone are to leave time for with a graphics card (1/s).
    """
    views.round(renderer, 0)
    card, costs, on_card = OnCard(renderer, context), [], []
    for number in range(1, 4 * rounds + 1):
        before = card.spent
        costs.append(views.round(card, number))
        on_card.append(card.spent - before)
    count = len(views)
    drawing = statistics.median(on_card) / count
    wall = statistics.median(cost.wall for cost in costs)
    encoding = statistics.median(cost.encoding for cost in costs)
    return [
        Figure(f"{name}: GPU time of a picture", drawing * 1e3, "ms"),
        Figure(f"{name}: encoding of a picture", encoding * 1e3, "ms"),
        Figure(
            f"{name}: each view, by GPU time and encoding",
            1.0 / (count * (drawing + encoding)),
            "fps",
            at_least=rate if renderer.on_card else None,
        ),
        Figure(f"{name}: picture with lens and JPEG", wall * 1e3, "ms"),
        Figure(f"{name}: each view, one after the other", 1.0 / (count * wall), "fps"),
    ]


if __name__ == "__main__":
    record()
