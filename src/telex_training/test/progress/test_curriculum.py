"""Curricula: files and their checks, what repetitions count for, and what is due."""

from pathlib import Path

import pytest
from recorded_trials import record, wall_of

from telex_training.command_lines.curriculum import main
from telex_training.progress.curriculum_check import check_curriculum
from telex_training.progress.curriculum_file import (
    CurriculumError,
    Proficient,
    curricula,
    load_curriculum,
    parse_curriculum,
)
from telex_training.progress.standing import Credit, credit, standing
from telex_training.progress.trial_facts import read_trial

FILE = Path("/curricula/mine.yaml")
LEAST = "modules: [{exercise: slalom, setting: day}]\n"
COURSE = """
modules:
  - {exercise: slalom, setting: day, proficient: {consecutive: 2, more: 2, most: 8}}
  - {exercise: gap, setting: gap_20, needs: [slalom], proficient: {consecutive: 1}}
exam: [{exercise: slalom, setting: day, repetitions: 3, faults: 1}]
currency: {days: 10, exercise: slalom, setting: day}
"""


def found(text):
    return [str(each) for each in check_curriculum(parse_curriculum(text, FILE))]


class TestFiles:
    def test_defaults_are_those_of_the_documentation(self):
        made = parse_curriculum(LEAST, FILE)
        assert (made.name, made.title, made.exam, made.currency) == ("mine", "mine", (), None)
        (module,) = made.modules
        assert (module.name, module.needs) == ("slalom", ())
        assert module.proficient == Proficient(consecutive=2, more=0, most=0)

    @pytest.mark.parametrize(
        ("text", "message"),
        [
            ("[]", "a struct with the key 'modules' is needed"),
            ("name: x", "modules is missing; one module at least is needed"),
            ("modules: []", "modules is []; one module at least is needed"),
            ("modules: 3", "modules is '3'; a list is needed"),
            ("modules: [{}]", "modules[0]/exercise is missing"),
            ("modules: [{exercise: ''}]", "modules[0]: exercise is ''; it must not be empty"),
            (LEAST + "exams: []", "exams is unknown; known are name, title, description, modules"),
            ("modules: [{exercise: a, need: [b]}]", "modules[0]/need is unknown; known are"),
            ("modules: [{exercise: a, needs: b}]", "modules[0]/needs is 'b'; a list is needed"),
            (
                "modules: [{exercise: a}, {exercise: a, setting: b}]",
                "modules[1]/name is 'a'; another module has it already",
            ),
            (
                "modules: [{exercise: a, proficient: {consecutive: 2, more: 10, most: 8}}]",
                "modules[0]/proficient: most is 8; consecutive and more ask for 12 repetitions",
            ),
            (
                "modules: [{exercise: a, proficient: {consecutive: 0}}]",
                "modules[0]/proficient: consecutive is 0; it must be at least 1",
            ),
            (
                "modules: [{exercise: a, proficient: {consecutive: 2.5}}]",
                "modules[0]/proficient/consecutive is 2.5; an integer is needed",
            ),
            (
                LEAST + "exam: [{exercise: a, repetitions: 2, faults: 2}]",
                "exam[0]: faults is 2; of 2 repetitions, fewer than that",
            ),
            (
                LEAST + "currency: {days: .nan, exercise: slalom}",
                "currency/days is nan; it must be finite",
            ),
            (LEAST + "currency: {days: 0, exercise: a}", "currency: days is 0.0; it must be above"),
        ],
    )
    def test_what_is_wrong_is_named_with_what_would_be_right(self, text, message):
        with pytest.raises(CurriculumError) as caught:
            parse_curriculum(text, FILE)
        assert str(caught.value).startswith(f"{FILE}: {message}")

    def test_a_file_that_is_not_there_is_named(self, tmp_path):
        with pytest.raises(CurriculumError, match=r"none\.yaml: No such file"):
            load_curriculum(tmp_path / "none.yaml")


class TestCheck:
    def test_the_shipped_ones_are_right(self):
        assert set(curricula()) >= {"telex_basic", "telex_manipulation", "telex_stairs"}
        for path in curricula().values():
            assert check_curriculum(load_curriculum(path)) == []

    @pytest.mark.parametrize(
        ("text", "message"),
        [
            (
                "modules: [{exercise: slalon}]",
                "modules[0] (slalon)/exercise: it is 'slalon'; there are: slalom, ",
            ),
            (
                "modules: [{exercise: slalom, setting: noon}]",
                "modules[0] (slalom)/setting: it is 'noon'; there are: day, dusk, night, cones_3",
            ),
            (
                "modules: [{exercise: ./slalom.yaml}]",
                "modules[0] (slalom)/exercise: it is './slalom.yaml'; the name of an exercise is",
            ),
            (
                "modules: [{exercise: slalom, needs: [gap]}]",
                "modules[0] (slalom)/needs: it is 'gap'; there are: slalom",
            ),
            (
                LEAST + "exam: [{exercise: slalom, repetitions: 11}]",
                "exam[0] (slalom)/repetitions: it is 11; a trial of this exercise ends after 10",
            ),
            (
                LEAST + "exam: [{exercise: slalom, repetitions: 5}]",
                "note: exam[0] (slalom)/repetitions: it is 5; a trial of this exercise goes on",
            ),
            (
                LEAST + "currency: {days: 9, exercise: slalom, setting: x}",
                "currency/setting: it is 'x'; there are",
            ),
        ],
    )
    def test_names_that_there_are_not_are_told(self, text, message):
        (finding,) = found(text)
        assert finding.startswith(message)

    def test_a_circle_is_told_once_with_all_that_stands_behind_it(self):
        text = """
        modules:
          - {exercise: slalom, needs: [gap]}
          - {exercise: gap, needs: [hurdle]}
          - {exercise: hurdle, needs: [slalom]}
          - {exercise: stairs, needs: [hurdle]}
          - {exercise: door}
          - {exercise: valve, needs: [valve]}
        """
        assert found(text) == [
            "modules[0] (slalom)/needs: they go round in a circle, slalom -> gap -> hurdle -> "
            "slalom; one of these needs has to go",
            "modules[5] (valve)/needs: they go round in a circle, valve -> valve; one of these "
            "needs has to go",
            "modules[3] (stairs): it cannot be reached: it needs gap, hurdle, slalom, which cannot "
            "be reached",
        ]

    def test_what_needs_a_missing_module_cannot_be_reached_either(self):
        text = """
        modules:
          - {exercise: slalom, needs: [nowhere]}
          - {exercise: gap, needs: [slalom]}
        """
        assert found(text) == [
            "modules[0] (slalom)/needs: it is 'nowhere'; there are: slalom, gap",
            "modules[1] (gap): it cannot be reached: it needs slalom, which cannot be reached",
        ]

    def test_the_command_says_what_is_wrong_and_fails(self, tmp_path, capsys):
        path = tmp_path / "mine.yaml"
        path.write_text("modules: [{exercise: slalom, needs: [gap]}]")
        assert main(["check", str(path)]) == 1
        assert f"{path}: modules[0] (slalom)/needs: it is 'gap'" in capsys.readouterr().err
        assert main(["check", "telex_basic"]) == 0
        assert "OK, 7 modules" in capsys.readouterr().out
        assert main(["check", "telex_basics"]) == 1
        assert "there is no curriculum 'telex_basics'; there are: telex_basic" in (
            capsys.readouterr().err
        )
        assert main(["list"]) == 0
        assert "telex_stairs: Slopes and stairs" in capsys.readouterr().out


RULE = Proficient(consecutive=2, more=3, most=10)


class TestCredit:
    @pytest.mark.parametrize(
        ("passed", "expected"),
        [
            ("", Credit(0, 0, 0, False)),
            ("+", Credit(1, 0, 1, False)),
            ("+-+", Credit(1, 0, 3, False)),
            ("-++", Credit(2, 0, 3, False)),
            ("++-+-+", Credit(2, 2, 6, False)),
            ("++-+-+--+", Credit(2, 3, 9, True)),
            ("+++++-----", Credit(2, 3, 5, True)),
            ("--------+++++", Credit(2, 0, 10, False)),
        ],
    )
    def test_first_in_a_row_then_more_within_the_most(self, passed, expected):
        assert credit([each == "+" for each in passed], RULE) == expected

    def test_without_a_most_any_number_counts(self):
        rule = Proficient(consecutive=2)
        assert credit([False] * 500 + [True] * 2, rule).mastered


class TestStanding:
    @pytest.fixture
    def stand(self, tmp_path_factory, monkeypatch):
        monkeypatch.setenv("ROS_HOME", str(tmp_path_factory.mktemp("home")))
        course = parse_curriculum(COURSE, FILE)

        def stand(*trials, days=1.0):
            read = []
            folder = tmp_path_factory.mktemp("recordings")
            for i, changes in enumerate(trials):
                signed = changes.get("mode") == "exam"
                given = {"exercise": "slalom", "setting": "day", "signed": signed, **changes}
                given["times"] = [(20.0, each == "+") for each in given["times"]]
                path = record(folder, stamp=f"2026-03-{i + 1:02d}_080000", **given)
                read.append(read_trial(path))
            last = read[-1].began if read else wall_of("2026-03-01_080000")
            return standing(course, read, last + days * 86400.0)

        return stand

    def states(self, made):
        return [each.state for each in made.modules]

    def test_at_the_beginning_what_needs_nothing_is_due(self, stand):
        made = stand()
        assert (made.begun, self.states(made)) == (False, ["open", "locked"])
        assert made.due == (
            "slalom, day: 2 passed in a row, then 2 more passed; 8 of 8 repetitions are left",
        )

    def test_what_is_begun_says_what_is_missing(self, stand):
        made = stand({"times": "-+"})
        assert (made.begun, self.states(made)) == (True, ["working", "locked"])
        assert made.due[0].startswith("slalom, day: 1 more passed in a row, after 1, then 2 more")

    def test_repetitions_of_several_trials_count_together(self, stand):
        made = stand({"times": "+"}, {"times": "++"}, {"times": "+"})
        assert self.states(made) == ["proficient", "open"]
        assert made.due[0].startswith("gap, gap_20: 1 passed in a row")

    def test_what_is_invalid_or_in_another_setting_does_not_count(self, stand):
        made = stand({"times": "++++", "valid": False}, {"times": "++++", "setting": "night"})
        assert self.states(made) == ["open", "locked"]

    def test_after_the_most_the_instructor_is_needed(self, stand):
        made = stand({"times": "-" * 8}, {"times": "++++"})
        assert self.states(made) == ["spent", "locked"]
        assert "talk to the instructor; 8 repetitions are done" in made.due[0]

    def test_the_exam_comes_last_and_wants_exam_mode(self, stand):
        trials = [{"times": "++++"}, {"times": "+", "exercise": "gap", "setting": "gap_20"}]
        made = stand(*trials)
        assert made.due == ("exam in slalom, day: 3 repetitions, of them at most 1 with a fault",)
        assert stand(*trials, {"times": "+++"}).due == made.due
        failed = stand(*trials, {"times": "+++", "mode": "exam", "verdict": "failed"})
        assert (failed.due, failed.exam[0].tries) == (made.due, 1)
        short = stand(*trials, {"times": "++", "mode": "exam"})
        assert short.due == made.due
        unsigned = stand(*trials, {"times": "+++", "mode": "exam", "signed": False})
        assert unsigned.due == made.due
        assert (unsigned.exam[0].tries, unsigned.exam[0].unsigned) == (0, 1)
        passed = stand(*trials, {"times": "+++", "mode": "exam"})
        assert passed.due == ()
        assert passed.exam[0].passed.endswith("_ann_slalom")

    def test_a_skill_that_was_not_shown_for_long_is_due_again(self, stand):
        assert stand({"times": "++++"}, days=9.9).due[0].startswith("gap")
        made = stand({"times": "++++"}, days=12.5)
        assert made.due[0] == (
            "slalom, day: again, a passed repetition; the last one counted for 10 days, which "
            "ended 3 days ago"
        )
        assert stand({"times": "----"}, days=99.0).current_until is None

    def test_an_empty_setting_is_the_exercises_first(self, tmp_path):
        course = parse_curriculum("modules: [{exercise: slalom}]", FILE)
        trials = [
            read_trial(record(tmp_path, exercise="slalom", setting="day", times=[(9.0, True)] * 2))
        ]
        assert standing(course, trials, 0.0).modules[0].state == "proficient"
