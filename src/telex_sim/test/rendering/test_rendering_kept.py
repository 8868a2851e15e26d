"""Pictures are not drawn again while nothing moves."""

import numpy as np
import pytest

from telex_control.common.geometry.matrices import pose_matrices
from telex_sim.cameras.cameras_config import CameraConfig
from telex_sim.cameras.drawing.gl_context import create_context
from telex_sim.cameras.drawing.kept_pictures import KeptPictures
from telex_sim.cameras.drawing.light.daylight import Lighting
from telex_sim.cameras.drawing.quality import TIERS
from telex_sim.cameras.drawing.renderer import Renderer
from telex_sim.cameras.optics.camera_sensor import CameraSensor
from telex_sim.cameras.optics.exposure import ExposureControl, exposure_factor
from telex_sim.cameras.optics.pinhole import PinholeCamera
from telex_sim.cameras.preview.still import looking
from telex_sim.scene.visual_scene import Daylight, Visual, VisualLamp, VisualScene, VisualShape

CAMERA = PinholeCamera(64, 48, 1.2, 0.05, 60.0)
OTHER = PinholeCamera(64, 48, 1.1, 0.05, 60.0)
FOCUS = np.zeros(3)
VIEW = looking((-2.0, 0.0, 1.0), (2.0, 0.0, 1.0))
PICTURE = np.full((48, 64, 4), 7, dtype=np.uint8)


def frames(x=0.0):
    return pose_matrices([(x, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)])


@pytest.fixture
def kept():
    made = KeptPictures()
    made.place(frames(), FOCUS, True)
    made.place(frames(), FOCUS, True)
    made.keep(CAMERA, VIEW, 1.0, PICTURE)
    return made


class TestWhatIsKept:
    def test_a_view_is_given_again(self, kept):
        kept.place(frames(5e-5), FOCUS, False)
        assert kept.find(CAMERA, VIEW, 1.001) is not PICTURE
        assert np.array_equal(kept.find(CAMERA, VIEW, 1.001), PICTURE)

    def test_another_view_is_not(self, kept):
        assert kept.find(OTHER, VIEW, 1.0) is None
        assert kept.find(CAMERA, looking((-2.0, 0.0, 1.001), (2.0, 0.0, 1.0)), 1.0) is None
        assert kept.find(CAMERA, VIEW, 1.1) is None

    def test_a_coarser_one_is_another(self, kept):
        assert kept.find(CAMERA, VIEW, 1.0, coarse=True) is None
        kept.keep(CAMERA, VIEW, 1.0, PICTURE + 1, coarse=True)
        assert np.array_equal(kept.find(CAMERA, VIEW, 1.0), PICTURE)
        assert np.array_equal(kept.find(CAMERA, VIEW, 1.0, coarse=True), PICTURE + 1)

    def test_a_picture_of_another_exposure_takes_its_place(self, kept):
        kept.keep(CAMERA, VIEW, 2.0, PICTURE + 1)
        assert kept.find(CAMERA, VIEW, 1.0) is None
        assert np.array_equal(kept.find(CAMERA, VIEW, 2.0), PICTURE + 1)

    def test_what_moves_ends_it(self, kept):
        kept.place(frames(2e-4), FOCUS, True)
        assert kept.find(CAMERA, VIEW, 1.0) is None

    def test_a_slow_drift_adds_up(self, kept):
        for step in range(1, 4):
            kept.place(frames(4e-5 * step), FOCUS, True)
        assert kept.find(CAMERA, VIEW, 1.0) is None

    def test_another_place_of_shadows_ends_it(self, kept):
        kept.place(frames(), FOCUS + 0.01, True)
        assert kept.find(CAMERA, VIEW, 1.0) is None

    def test_another_number_of_frames_ends_it(self, kept):
        kept.place(np.concatenate([frames(), frames()]), FOCUS, True)
        assert kept.find(CAMERA, VIEW, 1.0) is None

    def test_nothing_is_kept_while_things_move(self):
        made = KeptPictures()
        for x in (0.0, 0.1, 0.2):
            made.place(frames(x), FOCUS, True)
            made.keep(CAMERA, VIEW, 1.0, PICTURE)
            assert made.find(CAMERA, VIEW, 1.0) is None

    def test_nothing_is_kept_before_shadows_have_come_to_rest(self):
        made = KeptPictures()
        for recast in (True, False, False):
            made.place(frames(0.0 if recast else 0.1), FOCUS, recast)
            made.keep(CAMERA, VIEW, 1.0, PICTURE)
            assert made.find(CAMERA, VIEW, 1.0) is None
        made.place(frames(0.1), FOCUS, True)
        made.keep(CAMERA, VIEW, 1.0, PICTURE)
        assert made.find(CAMERA, VIEW, 1.0) is not None

    def test_there_are_not_too_many(self, kept):
        for number in range(100):
            kept.keep(CAMERA, looking((-2.0, 0.1 * number, 1.0), (2, 0, 1)), 1.0, PICTURE)
        assert kept.find(CAMERA, VIEW, 1.0) is None
        assert kept.find(CAMERA, looking((-2.0, 9.9, 1.0), (2, 0, 1)), 1.0) is not None


WALL = Visual(
    "world", VisualShape.BOX, (0.1, 8.0, 4.0), (4.0, 0.0, 2.0), color=(0.5, 0.5, 0.5, 1.0)
)
POST = Visual("thing", VisualShape.BOX, (0.1, 0.3, 0.6), color=(0.8, 0.2, 0.2, 1.0))
NIGHT = Daylight(sun=(0.0, 0.0, 0.0), ambient=0.02)
LAMP = VisualLamp(
    frame="world",
    position=(0.0, 0.0, 1.0),
    direction=(1.0, 0.0, 0.0),
    angle=1.2,
    intensity=6.0,
    reach=12.0,
    name="front",
)


@pytest.fixture
def renderer():
    context = create_context()
    with context:
        made = Renderer(context, TIERS["software"], Lighting(), lambda name: name)
        assert (
            made.load_scene(VisualScene(1, ("world", "thing"), (WALL, POST), (LAMP,), NIGHT)) == []
        )
        made.set_lamp_levels({"front": 1.0})
        yield made
    made.release()


def picture(renderer, thing=0.0, exposure=1.0):
    poses = [(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0), (2.0, thing, 1.0, 0.0, 0.0, 0.0, 1.0)]
    renderer.place(pose_matrices(poses), FOCUS)
    return renderer.render(CAMERA, VIEW, exposure)[..., :3].copy()


class TestTheRenderer:
    def test_it_gives_the_same_picture_as_it_drew(self, renderer):
        drawn = [picture(renderer) for _ in range(4)]
        for each in drawn[1:]:
            assert np.array_equal(each, drawn[0])

    @pytest.mark.parametrize("distortion", [(-0.12, 0.02, 0.0, 0.0, 0.0), (0.0,) * 5])
    def test_a_sensor_sees_what_it_would_of_a_new_picture(self, renderer, distortion):
        config = CameraConfig(64, 48, 1.2, distortion=distortion, noise=2.0, frame="optical")
        sensor = CameraSensor(config, 1.0, 7, ExposureControl())
        seen = []
        for _ in range(5):
            picture(renderer)
            ev = sensor.expose(10**9)
            drawn = renderer.render(sensor.pinhole, VIEW, exposure_factor(ev))
            seen.append(sensor.develop([drawn], renderer.repeats, ev, 10**9).copy())
            picture(renderer)  # in the same memory
        assert renderer.repeats
        for each in seen[1:]:
            assert np.array_equal(each, seen[0])

    def test_what_others_write_into_a_picture_is_not_kept(self, renderer):
        drawn = [picture(renderer) for _ in range(3)][-1]
        renderer.render(CAMERA, VIEW)[:] = 0
        assert np.array_equal(picture(renderer), drawn)

    def test_movement_light_and_exposure_are_seen_at_once(self, renderer):
        for _ in range(3):
            before = picture(renderer)
        assert not np.array_equal(picture(renderer, exposure=0.5), before)
        assert not np.array_equal(picture(renderer, thing=0.4), before)
        assert np.array_equal(picture(renderer), before)
        picture(renderer)
        renderer.set_lamp_levels({"front": 0.0})
        assert picture(renderer).mean() < 0.5 * before.mean()

    def test_depths_are_those_of_the_view_though_it_was_not_drawn(self, renderer):
        for _ in range(3):
            picture(renderer)
        depths = renderer.depth(CAMERA)
        aside = looking((-2.0, 3.0, 1.0), (2.0, 3.0, 1.0))
        renderer.render(CAMERA, aside)
        picture(renderer)
        assert np.array_equal(renderer.depth(CAMERA), depths)
        assert depths[24, 32] == pytest.approx(3.95, abs=0.01)
