"""Pictures whose content nobody learns from their name, and scenes that are given as text."""

import os
import stat
from pathlib import Path

import numpy as np
import pytest
import rospkg

from telex_control.common.params import ConfigError
from telex_sim.scene import sealed
from telex_sim.scene.answers import answers
from telex_sim.scene.assets import Assets
from telex_sim.scene.files.scene_file import SceneError
from telex_sim.scene.library.accelerator.vacuum import FlangeLine
from telex_sim.scene.planning import plan_world
from telex_sim.scene.textures.procedural import (
    TextureNameError,
    chart_answers,
    check_texture,
    generate_texture,
)

TOKEN = "0123456789abcdef"


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    monkeypatch.setattr(rospkg, "get_ros_home", lambda: str(tmp_path / "ros"))
    sealed._key.cache_clear()
    yield tmp_path / "ros"
    sealed._key.cache_clear()


class TestKey:
    def test_only_the_user_can_read_it(self, home):
        sealed.seed_of(TOKEN)
        mode = stat.S_IMODE(os.stat(home / sealed.FILE).st_mode)
        assert mode == 0o600
        assert [path.name for path in home.iterdir()] == [sealed.FILE]

    def test_another_process_finds_the_same_key(self):
        first = sealed.seed_of(TOKEN)
        sealed._key.cache_clear()
        assert sealed.seed_of(TOKEN) == first

    def test_another_key_means_another_seed(self, home):
        first = sealed.seed_of(TOKEN)
        (home / sealed.FILE).unlink()
        sealed._key.cache_clear()
        assert sealed.seed_of(TOKEN) != first

    def test_a_broken_key_is_named(self, home):
        home.mkdir()
        (home / sealed.FILE).write_bytes(b"short")
        with pytest.raises(ConfigError, match="5 bytes; 32 are needed"):
            sealed.seed_of(TOKEN)

    def test_tokens_differ(self):
        tokens = {sealed.new_token() for _ in range(100)}
        assert len(tokens) == 100
        assert all(sealed.TOKEN.fullmatch(token) for token in tokens)


class TestPictures:
    def test_the_chart_shows_what_the_answers_say(self):
        entry = {"type": "chart", "kind": "C", "rows": 4, "sealed": TOKEN}
        seed = sealed.seed_of(TOKEN)
        assert answers(entry) == answers({**entry, "sealed": "", "seed": seed})
        assert np.array_equal(
            generate_texture(f"generated:chart?kind=C&sealed={TOKEN}&rows=4"),
            generate_texture(f"generated:chart?kind=C&seed={seed}&rows=4"),
        )

    def test_pipes_show_what_the_answers_say(self):
        (row,) = answers({"type": "inspection_pipes", "sealed": TOKEN})
        words = {
            "right": 0,
            "up right": 45,
            "up": 90,
            "up left": 135,
            "left": 180,
            "down left": 225,
            "down": 270,
            "down right": 315,
        }
        for index, word in enumerate(row):
            assert np.array_equal(
                generate_texture(f"generated:optotype?kind=C&sealed={TOKEN}&of={index}"),
                generate_texture(f"generated:optotype?kind=C&angle={words[word]}"),
            )

    def test_many_tokens_give_all_directions(self):
        found = {
            word
            for _ in range(60)
            for word in answers({"type": "inspection_pipes", "sealed": sealed.new_token()})[0]
        }
        assert len(found) == 8

    def test_a_sealed_name_tells_no_answers(self):
        with pytest.raises(TextureNameError, match="sealed"):
            chart_answers(f"generated:chart?kind=C&sealed={TOKEN}&rows=4")

    @pytest.mark.parametrize("token", ["", "ABCDEF01", "short", "0" * 65, "../../etc"])
    def test_a_wrong_token_is_refused(self, token):
        with pytest.raises(TextureNameError, match="hexadecimal"):
            check_texture(f"generated:chart?sealed={token}")

    def test_nothing_of_a_scene_tells_the_answers(self):
        text = f"objects:\n  - {{type: chart, sealed: {TOKEN}}}\n"
        seed = str(sealed.seed_of(TOKEN))
        (item,) = plan_world(text, Assets()).scene.objects
        assert TOKEN in repr(item)
        assert seed not in repr(item)

    def test_a_leak_is_where_the_answers_say_and_any_flange_can_have_it(self):
        found = set()
        for _ in range(60):
            token = sealed.new_token()
            ((number,),) = answers({"type": "flange_line", "sealed": token, "leak": 3})
            text = f"objects:\n  - {{type: flange_line, sealed: {token}, leak: 3}}\n"
            (item,) = plan_world(text, Assets()).scene.objects
            leak = item.model.links[0].leak
            assert leak.position[0] == pytest.approx(0.7 * (int(number) - 4.5))
            found.add(number)
        assert found == {str(number) for number in range(1, 9)}

    def test_what_is_sent_of_a_line_of_flanges_is_the_same_wherever_it_leaks(self):
        links = [FlangeLine(leak=number).build(Path())[0].model.links[0] for number in range(9)]
        assert len({link.parts for link in links}) == 1

    def test_what_cannot_be_read_is_refused(self):
        with pytest.raises(
            ConfigError, match="type is 'cube'; chart, inspection_pipes or flange_line"
        ):
            answers({"type": "cube"})


class TestText:
    def test_a_text_is_a_scene(self):
        planned = plan_world("name: yard\nobjects:\n  - {type: cube}\n", Assets())
        assert planned.scene.name == "yard"
        assert [item.name for item in planned.scene.objects] == ["cube_1"]

    def test_one_without_a_name_is_called_text(self):
        assert plan_world("objects: []\n", Assets()).scene.name == "text"

    def test_what_is_wrong_is_named(self):
        with pytest.raises(SceneError, match=r"text: objects\[0\].*edge is -1"):
            plan_world("objects:\n  - {type: cube, edge: -1}\n", Assets())

    def test_it_has_no_folder(self):
        with pytest.raises(SceneError, match=r"'part.obj' is relative"):
            plan_world("objects:\n  - {type: mesh, mesh: part.obj, mass: 1}\n", Assets())

    def test_a_long_one_is_refused(self):
        with pytest.raises(SceneError, match="at most"):
            plan_world("description: |\n" + "  x\n" * 400_000, Assets())
