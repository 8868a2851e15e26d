import cv2
import numpy as np
import pytest

from telex_sim.cameras.drawing.smoothing import smooth_edges
from telex_sim.scene.textures.picture_files import MAX_TEXTURE_SIZE, TextureFileError, load_texture


class TestLoading:
    def test_colours_are_in_order(self, tmp_path):
        path = str(tmp_path / "red.png")
        cv2.imwrite(path, np.full((4, 6, 3), (0, 0, 200), np.uint8))
        picture = load_texture(tmp_path / "red.png")
        assert picture.shape == (4, 6, 3)
        assert picture[0, 0].tolist() == [200, 0, 0]

    def test_large_ones_are_reduced(self, tmp_path):
        cv2.imwrite(str(tmp_path / "a.png"), np.zeros((100, 2 * MAX_TEXTURE_SIZE, 3), np.uint8))
        assert load_texture(tmp_path / "a.png").shape == (50, MAX_TEXTURE_SIZE, 3)

    @pytest.mark.parametrize(
        ("size", "reduced"),
        [((1, 5000), (1, MAX_TEXTURE_SIZE)), ((5000, 1), (MAX_TEXTURE_SIZE, 1))],
    )
    def test_of_strips_a_line_remains(self, tmp_path, size, reduced):
        cv2.imwrite(str(tmp_path / "strip.png"), np.full((*size, 3), 90, np.uint8))
        picture = load_texture(tmp_path / "strip.png")
        assert picture.shape == (*reduced, 3)
        assert (picture == 90).all()

    def test_a_picture_that_opencv_refuses_is_named(self, tmp_path):
        # A header that promises more pixels than OpenCV takes.
        (tmp_path / "huge.pgm").write_bytes(b"P5 100000 100000 255\n")
        with pytest.raises(TextureFileError, match=r"huge\.pgm: OpenCV cannot read it: .*pixels"):
            load_texture(tmp_path / "huge.pgm")

    def test_missing_file_is_named(self, tmp_path):
        with pytest.raises(TextureFileError, match=r"nowhere\.png: no such file"):
            load_texture(tmp_path / "nowhere.png")

    def test_what_may_not_be_looked_up_is_named(self, tmp_path):
        # As for a folder that may not be searched, but for root as well.
        with pytest.raises(TextureFileError, match=r"aaa\.png: File name too long"):
            load_texture(tmp_path / f"{'a' * 300}.png")

    def test_what_is_no_picture_is_named(self, tmp_path):
        (tmp_path / "text.png").write_text("not a picture")
        with pytest.raises(TextureFileError, match=r"text\.png: no picture"):
            load_texture(tmp_path / "text.png")


class TestSmoothing:
    def test_softens_edges_and_leaves_the_rest(self):
        picture = np.zeros((20, 20, 4), np.uint8)
        picture[:, 10:] = 255
        smooth_edges(picture)
        assert 0 < picture[5, 9, 1] < picture[5, 10, 1] < 255
        assert (picture[:, :8] == 0).all()
        assert (picture[:, 12:] == 255).all()

    def test_leaves_faint_differences(self):
        picture = np.full((20, 20, 4), 100, np.uint8)
        picture[::2] = 108
        before = picture.copy()
        np.testing.assert_array_equal(smooth_edges(picture), before)
