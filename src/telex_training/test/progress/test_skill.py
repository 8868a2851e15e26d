"""Skills, comparisons, exports and reports of made-up trials."""

import csv
import io
import json
import re
from xml.etree import ElementTree

import pytest
from recorded_trials import record

from telex_training.judging.stats import reliability_bound
from telex_training.progress.comparison import ComparisonError, compare
from telex_training.progress.curriculum_file import curricula, load_curriculum
from telex_training.progress.exports import repetitions_csv, statements, statements_text, trials_csv
from telex_training.progress.index import ProgressIndex
from telex_training.progress.reports.class_report import (
    class_report,
    comparison_lines,
    comparison_report,
)
from telex_training.progress.reports.person_report import person_report
from telex_training.progress.reports.svg_figures import learning_figure, nice_step
from telex_training.progress.skill import decision, skills
from telex_training.progress.trial_facts import read_trial

NOW = 1.8e9


@pytest.fixture
def trials(tmp_path):
    """Makes trials, the oldest first."""
    made = []

    def make(operator="ann", **changes):
        stamp = f"2026-03-{len(made) + 1:02d}_080000"
        made.append(read_trial(record(tmp_path, operator, stamp, **changes)))
        return made

    return make


class TestSkill:
    def test_its_figures_are_those_of_the_valid_trials(self, trials):
        trials(times=[(40.0, False), (0.0, False), (30.0, True)])
        trials(times=[(20.0, True)] * 3, valid=False)
        (skill,) = skills(trials(times=[(24.0, True), (22.0, True)]))
        assert (skill.trials, skill.invalid, len(skill.repetitions), skill.passed) == (2, 1, 5, 3)
        assert skill.times == (40.0, 30.0, 24.0, 22.0)
        assert skill.best == 22.0
        assert (skill.recent, skill.recent_faults) == (5, 1)
        assert skill.reliability == reliability_bound(5, 1)
        # 60 / the mean time, to 60 / 10 s of the expert
        assert skill.proficiency == pytest.approx(10.0 / 29.0)
        assert skill.curve is None

    def test_times_however_far_apart_have_a_curve(self, trials):
        (skill,) = skills(trials(times=[(1e-4, True)] * 3 + [(1e6, True)] * 3))
        assert all(0.0 <= each.high < 1e60 for each in skill.curve)
        learning_figure(skill.times, skill.curve)
        (skill,) = skills(trials(times=[(1e-300, True)] * 6))
        assert skill.curve is None

    def test_from_six_completed_repetitions_on_there_is_a_curve(self, trials):
        (skill,) = skills(trials(times=[(30.0 / n, True) for n in range(1, 7)]))
        assert [each.number for each in skill.curve] == list(range(1, 17))
        assert skill.curve[-1].expected == pytest.approx(30.0 / 16)

    def test_what_was_long_ago_says_nothing_of_reliability(self, trials):
        trials(times=[(0.0, False)] * 30)
        (skill,) = skills(trials(times=[(20.0, True)] * 20))
        assert (skill.recent, skill.recent_faults) == (20, 0)

    def test_people_exercises_and_settings_are_kept_apart(self, trials):
        trials()
        trials("bob")
        trials(setting="night")
        found = [(each.operator, each.setting) for each in skills(trials("bob"))]
        assert found == [("ann", "standard"), ("bob", "standard"), ("ann", "night")]

    def test_the_weakest_metrics_are_those_that_miss_most_then_those_nearest_to_it(self, trials):
        # contacts: beyond where not passed; margin: 0.5 for 0.4, a quarter away; time: a third
        (skill,) = skills(trials(times=[(20.0, True), (20.0, False), (20.0, True)]))
        first, second = skill.weakest
        assert (first.metric.name, first.missed, first.count) == ("contacts", 1, 3)
        assert (second.metric.name, second.missed) == ("margin", 0)
        assert second.shortfall == pytest.approx(-0.25)

    def test_the_cusum_decides_by_success_and_failure(self, trials):
        good = skills(trials(times=[(20.0, True)] * 15))[0]
        assert decision(good.cusum) == "acceptable"
        bad = skills(trials("bob", times=[(20.0, False)] * 6))[1]
        assert decision(bad.cusum) == "unacceptable"
        young = skills(trials("eve", times=[(20.0, True)] * 2))[2]
        assert decision(young.cusum) == ""


class TestComparison:
    def test_a_person_counts_once(self, trials):
        trials("a1", times=[(10.0, True), (12.0, True), (14.0, True)])
        trials("a2", times=[(20.0, True)], verdict="failed")
        trials("b1", times=[(30.0, True)])
        trials("b1", times=[(34.0, True)], verdict="failed")
        made = compare(
            trials("b2", times=[(40.0, True)]), {"A": ["a1", "a2"], "B": ["b1", "b2"]}, "drill"
        )
        first, second = made.groups
        assert first.medians == {"a1": 12.0, "a2": 20.0}
        assert second.medians == {"b1": 32.0, "b2": 40.0}
        assert (first.repetitions, second.repetitions) == (4, 3)
        assert ((first.passed, first.failed), (second.passed, second.failed)) == ((1, 1), (1, 1))
        assert made.difference.value == 20.0
        assert made.chance == 1.0
        lines = comparison_lines(made)
        assert "B less A: +20 s; 95 % interval" in lines[0]
        assert all("n = 2 and 2" in line for line in lines)
        assert "Two groups" in comparison_report(made)

    def test_who_has_done_nothing_is_named(self, trials):
        trials("a1")
        trials("a2", times=[(0.0, False)])
        made = compare(trials("b1"), {"A": ["a1", "a2"], "B": ["b1"]}, "drill")
        assert made.groups[0].without == ("a2",)
        assert made.difference is None
        lines = comparison_lines(made)
        assert "none; two people a group are needed (n = 1 and 1 people)" in lines[0]
        assert lines[-1] == "A: no completed repetition of a2."

    def test_other_metrics_of_repetitions_can_be_compared(self, trials):
        trials("a")
        made = compare(trials("b"), {"A": ["a"], "B": ["b"]}, "drill", metric="margin")
        assert made.groups[0].median == 0.5

    @pytest.mark.parametrize(
        ("groups", "more", "message"),
        [
            ({"A": ["a"]}, {}, "there are 1 groups; two with different names are needed"),
            ({"A": ["a"], "B": ["a"]}, {}, "a: in both groups; one is needed"),
            ({"A": ["a"], "B": []}, {}, "group B is empty; there are trials of: a, b"),
            ({"A": ["a"], "B": ["x"]}, {}, "group B is x; there are trials of: a, b"),
            ({"A": ["a"], "B": ["b"]}, {"setting": "no"}, "setting is 'no'; there are trials in"),
            ({"A": ["a"], "B": ["b"]}, {"metric": "no"}, "metric is 'no'; there are: contacts,"),
            ({"A": ["a"], "B": ["b"]}, {"mode": "exam"}, "exercise is 'drill'; there is no valid"),
        ],
    )
    def test_what_cannot_be_compared_is_told(self, trials, groups, more, message):
        trials("a")
        with pytest.raises(ComparisonError) as caught:
            compare(trials("b"), groups, "drill", **more)
        assert str(caught.value).startswith(message)


class TestExports:
    def test_a_table_has_a_row_a_trial(self, trials):
        made = trials('Ann, the "great"', times=[(20.0, True), (0.0, False)])
        (row,) = csv.DictReader(io.StringIO(trials_csv(made)))
        assert row["operator"] == 'Ann, the "great"'
        assert (row["began"], row["verdict"]) == ("2026-03-01T08:00:00.000Z", "passed")
        assert (row["repetitions"], row["faults"], row["passed"]) == ("2", "1", "1")

    def test_or_a_row_a_repetition(self, trials):
        rows = list(csv.DictReader(io.StringIO(repetitions_csv(trials()))))
        assert [row["seconds"] for row in rows] == ["20.0", "25.0"]
        assert [row["contacts"] for row in rows] == ["0.0", "1.0"]

    def test_exports_say_what_an_exams_signature_is(self, tmp_path, monkeypatch):
        monkeypatch.setenv("ROS_HOME", str(tmp_path / "home"))
        for stamp, mode, signed in (
            ("2026-03-01_101500", "exam", True),
            ("2026-03-01_101600", "exam", False),
            ("2026-03-01_101700", "practice", False),
        ):
            record(tmp_path / "trials", stamp=stamp, mode=mode, signed=signed)
        index = ProgressIndex(tmp_path / "trials")
        assert index.refresh() == []
        made = index.trials()
        said = ["valid", "no signature", ""]
        for text in (trials_csv(made), repetitions_csv(made)):
            rows = {row["trial"]: row["signature"] for row in csv.DictReader(io.StringIO(text))}
            assert list(rows.values()) == said
        extensions = [each["context"]["extensions"] for each in statements(made)]
        assert [each["https://telex.example/xapi/signature"] for each in extensions] == said

    def test_statements_are_those_of_xapi(self, trials):
        trials(times=[(20.0, True), (20.0, True), (0.0, False), (25.0, True)])
        trials(verdict="failed")
        trials(valid=False)
        made = trials(verdict="", ended="abandoned")
        lines = statements_text(made).splitlines()
        found = [json.loads(line) for line in lines]
        assert [each["verb"]["id"].rsplit("/", 1)[1] for each in found] == [
            "passed",
            "failed",
            "attempted",
            "attempted",
        ]
        first = found[0]
        assert first["result"]["score"] == {"scaled": 0.75, "raw": 3, "min": 0, "max": 4}
        assert (first["result"]["success"], first["result"]["completion"]) == (True, True)
        assert first["result"]["duration"] == "PT60.00S"
        assert first["timestamp"] == "2026-03-01T08:00:00.000Z"
        assert first["actor"]["account"]["name"] == "ann"
        assert first["object"]["id"] == "https://telex.example/exercises/drill/standard"
        assert "success" not in found[2]["result"]
        assert not found[3]["result"]["completion"]
        assert len({each["id"] for each in found}) == 4
        assert [each["id"] for each in statements(made)] == [each["id"] for each in found]

    def test_extensions_are_named_by_addresses(self, trials):
        (made,) = statements(trials(), "https://school.example")
        for extensions in (made["result"]["extensions"], made["context"]["extensions"]):
            assert all(key.startswith("https://school.example/xapi/") for key in extensions)


def courses():
    return [load_curriculum(path) for path in curricula().values()]


def figures(text):
    return [ElementTree.fromstring(each) for each in re.findall(r"<svg.*?</svg>", text, re.DOTALL)]


class TestReports:
    def test_a_person_sees_what_is_due_and_how_it_went(self, trials):
        trials(exercise="slalom", setting="cones_3", times=[(60.0 / n, True) for n in range(1, 8)])
        text = person_report("ann", trials(verdict="failed"), courses(), NOW)
        assert "Driving, first course" in text
        assert "Slopes and stairs" not in text
        assert "slalom, day: 2 passed in a row, then 10 more passed; 80 of 80" in text
        assert "repetition 17 by the learning curve; 80 % band" in text
        assert "n = 7" in text
        assert "weakest metric 2" in text
        assert len(figures(text)) == 4

    def test_a_trial_that_is_not_valid_has_passed_nothing(self, trials):
        trials(verdict="passed", valid=False)
        trials(verdict="failed")
        trials(verdict="")
        text = person_report("ann", trials(verdict="passed"), [], NOW)
        cells = re.findall(r"<td>(?:<span class=\"(\w+)\">)?(\w+ ?\w+)(?:</span>)?</td><td", text)
        shown = [each for each in cells if each[1] in ("passed", "failed", "no verdict", "invalid")]
        assert shown == [("ok", "passed"), ("", "no verdict"), ("bad", "failed"), ("", "invalid")]

    def test_it_needs_nothing_beside_itself(self, trials):
        text = person_report("ann", trials(), courses(), NOW)
        assert not re.search(r"<(script|link|img)\b|(src|href)=|url\(|@import", text)

    def test_whoever_has_done_nothing_sees_where_to_begin(self):
        text = person_report("eve", [], courses(), NOW)
        assert "Driving, first course" in text
        assert "slalom, cones_3: 2 passed in a row" in text

    def test_names_are_text_and_no_markup(self, trials):
        name = "<script>alert(1)</script>&\"'"
        made = trials(name, title="<b>x</b>", setting="<i>", times=[(20.0, True)] * 7)
        for text in (
            person_report(name, made, courses(), NOW),
            class_report({name: made}, courses(), NOW, "<u>"),
        ):
            assert "<script" not in text
            assert "<b>" not in text
            assert "<i>" not in text
            assert "<u>" not in text
            assert figures(text)

    def test_a_class_is_shown_by_module_and_by_exercise(self, trials):
        trials(exercise="slalom", setting="cones_3", times=[(20.0, True)] * 4)
        made = trials("bob", exercise="slalom", setting="cones_3", times=[(30.0, False)] * 3)
        people = {"ann": made[:1], "bob": made[1:]}
        text = class_report(people, courses(), NOW)
        rows = re.findall(r"<tr><td>(\w+)</td><td class=\"mark\">([^<]*)</td>", text)
        assert rows == [("ann", "●"), ("bob", "◐ 0/4")]
        assert "contacts (3 of 3)" in text
        assert len(figures(text)) == 1

    def test_trials_without_a_repetition_are_no_error(self, trials):
        made = trials(times=[], verdict="")
        assert "none of them with a valid repetition" in person_report("ann", made, courses(), NOW)
        assert "<svg" not in class_report({"ann": made}, courses(), NOW)

    @pytest.mark.parametrize(
        ("span", "step"), [(1.0, 0.2), (9.0, 2.0), (100.0, 20.0), (0.03, 0.01), (0.0, 1.0)]
    )
    def test_axes_have_round_marks(self, span, step):
        assert nice_step(span, 5) == pytest.approx(step)

    def test_times_of_nothing_can_be_drawn(self):
        assert ">0<" in learning_figure([0.0, 0.0], None)
