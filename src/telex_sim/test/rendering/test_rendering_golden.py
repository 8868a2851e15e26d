"""Pictures of a known scene beside those that were looked at and found good, in test/golden.

After a deliberate change of the looks, make them anew and look at them:
GOLDEN=write pytest src/telex_sim/test/rendering/test_rendering_golden.py
"""

import os
from pathlib import Path

import cv2
import numpy as np
import pytest

from telex_control.common.geometry.matrices import pose_matrices
from telex_sim.cameras.drawing.light.daylight import Lighting
from telex_sim.cameras.drawing.quality import TIERS
from telex_sim.cameras.optics.pinhole import PinholeCamera
from telex_sim.cameras.preview.still import Still, looking
from telex_sim.scene.visual_scene import Daylight, Visual, VisualLamp, VisualScene, VisualShape

GOLDEN = Path(__file__).resolve().parents[1] / "golden"
CAMERA = PinholeCamera(160, 120, 1.0, 0.05, 60.0)

VISUALS = (
    Visual(
        "world",
        VisualShape.PLANE,
        (40.0, 40.0, 0.0),
        texture="generated:concrete",
        texture_scale=2.0,
    ),
    Visual(
        "world",
        VisualShape.BOX,
        (0.8, 0.8, 0.8),
        (2.5, 0.7, 0.4),
        texture="generated:wood",
        texture_scale=1.0,
    ),
    Visual(
        "world", VisualShape.SPHERE, (0.35, 0.0, 0.0), (2.0, -0.5, 0.35), color=(0.8, 0.1, 0.1, 1.0)
    ),
    Visual(
        "world",
        VisualShape.CYLINDER,
        (0.15, 0.0, 1.2),
        (3.5, -0.9, 0.6),
        color=(0.5, 0.5, 0.55, 1.0),
    ),
    Visual("world", VisualShape.BOX, (0.1, 8.0, 3.0), (6.0, 0.0, 1.5), color=(0.7, 0.7, 0.65, 1.0)),
)
HEADLIGHT = VisualLamp("robot", (0.2, 0.3, 0.5), (1.0, 0.0, -0.05), 1.3, 3.0, 12.0, name="front")
LIGHTS = {
    "day": (Daylight(), ()),
    "night": (Daylight(sun=(0.0, 0.0, 0.0), ambient=0.03), (HEADLIGHT,)),
    "fog": (Daylight(visibility=8.0, ambient=0.8), ()),
}


@pytest.fixture(scope="module", params=sorted(TIERS))
def tier(request):
    still = Still(TIERS[request.param], Lighting(), lambda name: name)
    yield request.param, still
    still.release()


@pytest.mark.parametrize("light", sorted(LIGHTS))
def test_the_scene_looks_as_it_did(tier, light):
    name, still = tier
    daylight, lamps = LIGHTS[light]
    assert still.load(VisualScene(1, ("world", "robot"), VISUALS, lamps, daylight)) == []
    still.renderer.set_lamp_levels({"front": 1.0})
    frames = pose_matrices([(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)] * 2)
    pose = looking((-0.3, 0.0, 1.1), (2.5, 0.0, 0.4))
    picture = still.picture(CAMERA, pose, frames, (2.0, 0.0, 0.0))
    path = GOLDEN / f"{light}_{name}.png"
    if os.environ.get("GOLDEN") == "write":
        cv2.imwrite(str(path), picture[..., ::-1])
    golden = cv2.imread(str(path))
    assert golden is not None, f"{path} is missing"
    difference = np.abs(picture.astype(int) - golden[..., ::-1].astype(int)).max(axis=2)
    # Renderers differ in the last bits, and by a pixel along edges.
    assert difference.mean() < 2.5
    assert np.percentile(difference, 97.0) < 25
