"""What a judgement shows: verdict and worst row first, then levels, reasons, and every cycle with its limits and units."""

from pathlib import Path

import pytest
from tests.campaigns.specimen_folders import QUASI_STATIC, dahl, specimen_folder

from dampyr.campaigns.judgement import DesignLevel, JudgedSpecimens, judge
from dampyr.identification.acceptance_tests.device_criteria import Criterion
from dampyr.show.descriptions import description_of

CRITERIA = [
    Criterion("effective_stiffness", "third", "design", "drawing 7", -0.15, 0.15),
    Criterion("energy", "all", "cycle 3", "drawing 8", -0.1),
]


@pytest.fixture(scope="module")
def judged(tmp_path_factory: pytest.TempPathFactory) -> JudgedSpecimens:
    """A specimen that is too weak, and one that was not run."""
    lab = tmp_path_factory.mktemp("shown")
    weak = specimen_folder(lab / "weak", QUASI_STATIC, dahl(180.0, 4000.0), specimen="SN 2")
    missing = specimen_folder(lab / "missing", QUASI_STATIC, dahl(300.0, 4000.0), states={1: "planned"})
    return judge([weak, missing], CRITERIA, [DesignLevel(0.004, effective_stiffness=75e3)])


def test_the_text_begins_with_the_verdict_and_names_the_worst_cycle(judged: JudgedSpecimens) -> None:
    rows = dict(description_of(judged).rows)
    assert list(rows) == ["verdict", "specimens", "criteria", "worst", "not judged"]
    assert (rows["verdict"], rows["specimens"]) == ("failed", "1 failed, 1 not judged")
    assert rows["worst"].startswith("effective stiffness of cycle 3, quasi static 4 mm at 10 mm/s, 0 V: 45")
    assert rows["worst"].endswith(" N/mm, at least 63.75 N/mm and at most 86.25 N/mm")


def test_every_cycle_has_criterion_limits_value_unit_and_verdict(judged: JudgedSpecimens) -> None:
    specimens, levels, unjudged, cycles = (make() for make in description_of(judged).tables)
    assert [row[:3] for row in specimens.rows] == [["SN 2", "failed", "1 of 1"], ["missing", "not judged", "0 of 1"]]
    assert [row[2:7] for row in levels.rows] == [["failed", 5, 5, 1, 6], ["not judged", 5, 0, 0, 0]]
    assert unjudged.rows == [["missing", "quasi static 4 mm at 10 mm/s, 0 V", "The test was not run."]]
    assert cycles.columns[2:] == (
        "cycle", "quantity", "reference", "lower limit", "upper limit", "value", "unit", "verdict", "source",
    )  # fmt: skip
    stiffness, energy = cycles.rows[0], cycles.rows[1]
    assert stiffness[2:5] == [3, "effective stiffness", "design"]
    assert stiffness[5:8] == pytest.approx([63.75, 86.25, 45.0], rel=0.02)
    assert stiffness[8:] == ["N/mm", "failed", "drawing 7"]
    assert energy[2:5] == [1, "energy", "cycle 3"]
    assert (energy[6], energy[8:]) == (None, ["J", "passed", "drawing 8"])
    frame = judged.to_dataframe()
    assert list(frame["holds"]) == [False] + [True] * 5
    assert frame["value"][0] == pytest.approx(45e3, rel=0.02)


def test_the_figure_has_the_loops_of_the_failed_specimen(judged: JudgedSpecimens) -> None:
    draw = description_of(judged).figure
    assert draw is not None
    figure = draw()
    assert figure is not None
    assert len(figure.axes[0].lines) == 5


def test_without_a_record_there_is_no_figure(tmp_path: Path) -> None:
    missing = specimen_folder(tmp_path, QUASI_STATIC, dahl(300.0, 4000.0), states={1: "planned"})
    draw = description_of(judge(missing, CRITERIA)).figure
    assert draw is not None
    assert draw() is None
