"""Exercises as environments: what learning programs may rely upon."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Iterator

import gymnasium
import numpy as np
import pybullet
import pytest
from ahead_exercise import AHEAD
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import check_env

from telex_control.common.params import ConfigError
from telex_sim.cameras.cameras_config import shipped_cameras
from telex_sim.cameras.preview.still_cameras import sized
from telex_training.exercises.catalog import exercises
from telex_training.research import environment_id, register
from telex_training.research.data_set import require_even_sides
from telex_training.research.environment import ExerciseEnv

pytestmark = pytest.mark.slow

EXERCISE = (
    AHEAD
    + """
  middle: {center: [0.35, 0.0, 0.5], size: [0.2, 1.0, 1.2]}
  there: {center: [0.7, 0.0, 0.5], size: [0.4, 1.0, 1.2]}
  allowed: {center: [0.8, 0.0, 0.5], size: [2.2, 1.0, 1.2]}
steps:
  - {name: half, until: {inside: {what: robot, zone: middle}}}
  - {name: whole, until: {inside: {what: robot, zone: there}}}
repetitions: {most: 3, time: 20, trial_time: 60}
questions: [{name: seen, ask: What is there?, choices: [a, b], answer: b}]
faults: [{name: backwards, when: {not: {inside: {what: robot, zone: allowed}}}}]
metrics: {time: {pass: 10}}
"""
)

PATIENCE = 60.0
"""For how long an operator waits for a line on which nothing passes (s)."""


@pytest.fixture(scope="module")
def exercise(tmp_path_factory: pytest.TempPathFactory) -> str:
    path: Path = tmp_path_factory.mktemp("exercises") / "ahead.yaml"
    path.write_text(EXERCISE)
    return str(path)


@pytest.fixture(scope="module")
def env(exercise: str) -> Iterator[ExerciseEnv]:
    made = ExerciseEnv(exercise)
    yield made
    made.close()


@pytest.mark.parametrize("weight", [np.nan, np.inf])
def test_weights_are_finite(exercise: str, weight: float) -> None:
    with pytest.raises(ValueError, match="a finite number is needed"):
        ExerciseEnv(exercise, weights={"time": weight})


def test_an_exercise_whose_name_is_no_id_is_left_out(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "ahead (2).yaml").write_text(EXERCISE)
    monkeypatch.setenv("TELEX_EXERCISE_PATH", str(tmp_path))
    with pytest.warns(UserWarning, match=r"exercise 'ahead \(2\)' is no environment"):
        register()


def test_pictures_of_a_data_set_have_even_sides() -> None:
    with pytest.raises(ConfigError, match="width is 161, which makes 'front' 161 x "):
        require_even_sides(sized(shipped_cameras(), ["front"], 161), 161)
    require_even_sides(sized(shipped_cameras(), ["front"], 160), 160)


def action(env: ExerciseEnv, **values: float) -> np.ndarray:
    made = np.zeros(len(env.action_names), np.float32)
    for name, value in values.items():
        made[env.action_names.index(name.replace("__", "."))] = value
    return made


def test_each_shipped_exercise_has_an_id() -> None:
    assert environment_id("cube_to_bin") == "telex/CubeToBin-v0"
    for name in exercises():
        assert gymnasium.spec(environment_id(name)).kwargs == {"exercise": name}


@pytest.mark.filterwarnings("ignore:.*infinity")
def test_gymnasium_finds_nothing_wrong(exercise: str) -> None:
    made = gymnasium.make("telex/Slalom-v0", exercise=exercise, cameras=("front",), width=64)
    check_env(made.unwrapped, skip_render_check=True)
    made.close()


class TestEpisode:
    def test_it_ends_when_the_judge_says_so(self, env: ExerciseEnv) -> None:
        seen, about = env.reset(seed=7)
        assert about["seed"] == 7
        assert about["phase"] == "waiting"
        assert seen[env.state_names.index("base.x")] == pytest.approx(0.0, abs=0.05)
        ahead, total, number = action(env, drive__linear=0.6), 0.0, 0
        while True:
            seen, reward, terminated, truncated, about = env.step(ahead)
            total, number = total + reward, number + 1
            assert number < 40
            if terminated or truncated:
                break
        assert terminated
        assert not truncated
        assert about["is_success"]
        assert about["passed"]
        assert about["fault"] == ""
        # Both steps, and the end; its time is a share of the 20 s that are allowed.
        assert total == pytest.approx(2.0 - about["elapsed"] / 20.0, abs=1e-4)
        assert seen[env.state_names.index("base.x")] > 0.5
        assert '"verdict"' in env.sheet()
        with pytest.raises(ResetNeeded, match="reset"):
            env.step(ahead)

    def test_a_fault_ends_it(self, exercise: str) -> None:
        env = ExerciseEnv(exercise, rate=2.0, weights={"fault": 5.0})
        env.reset(seed=7)
        back = action(env, drive__linear=-1.0)
        for _ in range(10):
            _, _, terminated, _, about = env.step(back)
            if terminated:
                break
        env.close()
        assert about["fault"] == "backwards"
        assert not about["is_success"]
        assert not about["passed"]
        assert about["reward_terms"]["fault"] == -5.0

    def test_rates_are_those_of_the_nodes(self, env: ExerciseEnv) -> None:
        env.reset(seed=7)
        most = float(env.action_space.high[env.action_names.index("turret.rate")])
        turn = action(env, turret__rate=100.0)
        place, seen = env.state_names.index("turret_joint"), []
        for _ in range(12):
            seen.append(env.step(turn)[0][place])
        assert np.diff(seen)[-4:] == pytest.approx(0.1 * most, rel=0.1)
        # Let go of, it comes to rest and stays.
        for _ in range(6):
            seen.append(env.step(action(env))[0][place])
        assert abs(seen[-1] - seen[-2]) < 1e-3

    def test_the_tool_is_led(self, exercise: str) -> None:
        env = ExerciseEnv(exercise, parts=("tool",))
        assert [name.partition(".")[0] for name in env.action_names] == 6 * ["tool"]
        before, _ = env.reset(seed=7)
        for _ in range(5):
            after = env.step(action(env, tool__z=0.1))[0]
        env.close()
        arm = slice(7, 14)
        assert np.abs(after[arm] - before[arm]).max() > 0.01

    def test_questions_are_answered_beside_actions(self, env: ExerciseEnv) -> None:
        env.close()
        with pytest.raises(ResetNeeded):
            env.answer("seen", "b")
        env.reset(seed=7)
        with pytest.raises(ValueError, match="has not begun"):
            env.answer("seen", "b")
        for _ in range(8):
            env.step(action(env, drive__linear=0.6))
        with pytest.raises(ValueError, match=r"question is 'what'; there are: seen"):
            env.answer("what", "b")
        env.answer("seen", "b")
        assert ("answer", "seen") in {
            (each["event"], each["name"]) for each in json.loads(env.sheet())["events"]
        }

    def test_an_outage_ends_nothing(self, tmp_path: Path) -> None:
        path = tmp_path / "ahead.yaml"
        path.write_text(f"{EXERCISE}link: {{outage_every: 4, outage_for: 3}}\n")
        env, seen = ExerciseEnv(str(path), parts=("drive",), rate=2.0), [b"a", b"b"]
        env.reset(seed=1)
        while seen[-1] != seen[-2]:
            seen.append(env.step(action(env, drive__linear=0.05))[0].tobytes())
        port: Any = env._trial and env._trial.port
        port._seen_at -= PATIENCE  # instead of a minute's simulation
        stood, _, terminated, truncated, _ = env.step(action(env))
        env.close()
        assert (stood.tobytes(), terminated, truncated) == (seen[-1], False, False)


class TestDeterminism:
    def test_the_same_seed_and_actions_show_the_same(self, exercise: str) -> None:
        env = ExerciseEnv(exercise, cameras=("front", "gripper"), width=64)

        def run(seed: int) -> Any:
            drawn = np.random.default_rng(3)
            shown = [env.reset(seed=seed)[0]]
            for _ in range(8):
                values = drawn.uniform(env.action_space.low, env.action_space.high)
                shown.append(env.step(values)[0])
            return [{name: value.tobytes() for name, value in each.items()} for each in shown]

        first, other, again = run(5), run(6), run(5)
        env.close()
        assert first == again
        assert first != other
        assert len({each["front"] for each in first}) > 5

    def test_pictures_come_as_late_as_all_else(self, exercise: str) -> None:
        env = ExerciseEnv(exercise, line="300", cameras=("front",), width=64)
        seen, _ = env.reset(seed=5)
        assert seen["front"].std() > 5.0
        late = [env.step(action(env, drive__linear=0.6))[0] for _ in range(10)]
        env.close()
        moved = [each["state"][0] != seen["state"][0] for each in late]
        assert not any(abs(each["state"][0] - seen["state"][0]) > 1e-3 for each in late[:3])
        assert moved[-1]


class TestRefusals:
    def test_bad_actions_do_nothing(self, env: ExerciseEnv) -> None:
        env.reset(seed=1)
        before = env.sheet()
        for given, message in (
            ([0.0], r"action has the shape \(1,\); \(16,\) is needed"),
            (None, r"action has the shape \(\)"),
            ("ahead", r"action is 'ahead'; an array of 16 numbers is needed"),
            (np.full(16, np.nan), r"action: drive.linear is nan; a finite number is needed"),
            (np.full(16, np.inf), r"action: drive.linear is inf"),
        ):
            with pytest.raises(ValueError, match=message):
                env.step(given)
        assert env.sheet() == before

    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            ({"exercise": "slalm"}, "there is no exercise 'slalm'"),
            ({"setting": "noon"}, "setting is 'noon'"),
            ({"line": "wet"}, "wet"),
            ({"parts": ("wings",)}, "parts has 'wings'"),
            ({"parts": ("arm", "tool")}, "one of them at a time"),
            ({"parts": ()}, "none of them"),
            ({"cameras": ("tail",)}, "camera is 'tail'"),
            ({"cameras": ("front",), "width": 4}, "width"),
            ({"rate": 7.0}, "rate is 7"),
            ({"rate": 1000.0}, "1 to 100"),
            ({"lamps": 2.0}, "lamps is 2"),
            ({"weights": {"joy": 1.0}}, "weights has 'joy'"),
            ({"render_mode": "human"}, "render_mode is 'human'"),
        ],
    )
    def test_bad_arguments(self, exercise: str, arguments: Any, message: str) -> None:
        with pytest.raises(ValueError, match=message):
            ExerciseEnv(**{"exercise": exercise, **arguments})

    def test_objects_that_are_not_there(self, exercise: str) -> None:
        env = ExerciseEnv(exercise, objects=("cube",))
        with pytest.raises(ValueError, match="objects has 'cube'"):
            env.reset(seed=1)
        env.close()


def test_closing_frees_all(exercise: str) -> None:
    before = [client for client in range(64) if pybullet.isConnected(client)]
    env = ExerciseEnv(exercise, cameras=("front",), width=64)
    env.reset(seed=1)
    env.close()
    env.close()
    assert [client for client in range(64) if pybullet.isConnected(client)] == before
    with pytest.raises(ResetNeeded):
        env.step(np.zeros(16))


def test_several_at_once_are_as_one(exercise: str) -> None:
    shown = {}
    for mode in ("sync", "async"):
        many = gymnasium.make_vec(
            "telex/Slalom-v0", num_envs=2, vectorization_mode=mode, exercise=exercise
        )
        seen, _ = many.reset(seed=[3, 4])
        stepped, *_ = many.step(np.array([many.single_action_space.high] * 2))
        shown[mode] = (seen.tobytes(), stepped.tobytes())
        many.close()
    assert shown["sync"] == shown["async"]
