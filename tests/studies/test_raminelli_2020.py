"""Raminelli (2020) run again: the known numbers come out, and a verdict follows its numbers."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from dampyr.errors import ExtrapolationWarning, MissingData, RangeError
from dampyr.studies import raminelli_2020
from dampyr.studies.raminelli_2020 import PUBLISHED, ComparedValue
from dampyr.studies.raminelli_2020.chapter_2 import chapter_2
from dampyr.studies.raminelli_2020.chapter_4_tables import table_4_1
from dampyr.studies.raminelli_2020.chapter_5 import chapter_5
from dampyr.studies.raminelli_2020.compared_value import PrintedNumber
from dampyr.studies.raminelli_2020.cubics import equations
from dampyr.studies.raminelli_2020.study import Study
from dampyr.studies.raminelli_2020.study_part import StudyPart

ARTEFACTS = (
    "Figure 2.2", "Figure 2.3", "Figure 2.4", "Section 2.4, step 2", "Section 2.4, steps 3 to 5", "Table 4.1", "Table 4.2",
    "Table 4.3", "Table 4.4", "Table 4.5", "(4.6)", "(4.7)", "(4.8)", "14.81 %", "21.71 %", "Figure 4.1", "Figure 4.2",
    "Figure 4.3", "Figure 4.4", "Figure 5.1", "Figure 5.4", "Section 5.2",
)  # fmt: skip


@pytest.fixture(scope="module")
def bare(tmp_path_factory: pytest.TempPathFactory) -> Study:
    """The study on a machine without the data."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("DAMPYR_DATA", str(tmp_path_factory.mktemp("no-data")))
        return raminelli_2020.reproduce(out=tmp_path_factory.mktemp("bare"))


@pytest.fixture(scope="module")
def study(campaign_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Study:
    """The study on the real files."""
    return raminelli_2020.reproduce(campaign_folder, tmp_path_factory.mktemp("study"))


@pytest.fixture(scope="module")
def second() -> StudyPart:
    """Chapter 2."""
    return chapter_2(PUBLISHED)


@pytest.fixture(scope="module")
def fifth() -> StudyPart:
    """Chapter 5."""
    return chapter_5(PUBLISHED)


def one(source: Study | StudyPart, artefact: str, start: str) -> ComparedValue:
    """The only value of an artefact whose quantity begins so."""
    matches = [f for f in source.compared if f.artefact == artefact and f.quantity.startswith(start)]
    assert len(matches) == 1, [f.quantity for f in source.compared if f.artefact == artefact]
    return matches[0]


class TestDamper:
    def test_the_cubics_in_si(self) -> None:
        damper = raminelli_2020.damper()
        at_0, at_2 = damper.at(0.0), damper.at(2.0)
        assert (at_0.kx, at_0.kw, at_0.rho) == (802.0, 50.237, 42745.0)
        assert at_2.kx == pytest.approx(1e3 * (0.0855 * 8 + 0.0342 * 4 + 0.4931 * 2 + 0.802), rel=1e-12)
        assert at_2.kw == pytest.approx(3.6157 * 8 - 24.866 * 4 + 201.92 * 2 + 50.237, rel=1e-12)
        assert at_2.rho == pytest.approx(1e3 * (-2.8368 * 8 + 17.881 * 4 - 39.038 * 2 + 42.745), rel=1e-12)

    def test_it_knows_its_range_and_where_it_comes_from(self) -> None:
        damper = raminelli_2020.damper()
        assert damper.range == (0.0, 3.212)
        assert "(4.6) to (4.8)" in damper.provenance["source"]
        with pytest.raises(RangeError):
            damper.at(3.6)
        with pytest.warns(ExtrapolationWarning):
            assert damper.at(3.6, allow_extrapolation=True).rho == pytest.approx(1592, abs=1)


class TestSection24:
    def test_the_example_is_recovered_and_the_printed_slope_is_the_nearest_samples(self, second: StudyPart) -> None:
        steps = "Section 2.4, steps 3 to 5"
        assert one(second, steps, "a of Step 4, exact").ours == pytest.approx(4457.6224, rel=1e-6)
        assert one(second, steps, "ρ of Step 1").ours == pytest.approx(705.32, rel=1e-6)
        assert one(second, steps, "a of Step 4, exact").verdict == "differs"
        sampled = one(second, steps, "a of Step 4, from the sample")
        assert (round(float(sampled.ours), 1), sampled.verdict) == (4466.3, "agrees")

    def test_step_2(self, second: StudyPart) -> None:
        assert {f.verdict for f in second.compared if f.artefact == "Section 2.4, step 2"} == {"agrees"}
        assert len([f for f in second.compared if f.artefact == "Section 2.4, step 2"]) == 5

    def test_figure_2_2(self, second: StudyPart) -> None:
        assert one(second, "Figure 2.2", "largest z").ours == pytest.approx(0.56512, abs=5e-6)

    def test_the_verdict_follows_the_printed_number(self) -> None:
        exact = replace(PUBLISHED, example=replace(PUBLISHED.example, a=PrintedNumber("4457.6")))
        assert one(chapter_2(exact), "Section 2.4, steps 3 to 5", "a of Step 4, exact").verdict == "agrees"
        far = replace(PUBLISHED, example=replace(PUBLISHED.example, a=PrintedNumber("4600.0")))
        value = one(chapter_2(far), "Section 2.4, steps 3 to 5", "a of Step 4, exact")
        assert "no phase" in value.reason
        assert "outside" in value.reason


class TestTable41AndCubics:
    def test_kx_and_kw_follow_and_rho_is_nine_rows(self) -> None:
        part = table_4_1(PUBLISHED)
        for name in ("kx", "kw"):
            assert one(part, "Table 4.1", f"mean of {name}").verdict == "agrees"
            assert one(part, "Table 4.1", f"s.d. of {name}").verdict == "agrees"
        mean, spread = one(part, "Table 4.1", "mean of ρ"), one(part, "Table 4.1", "s.d. of ρ")
        assert (mean.ours, spread.ours) == (pytest.approx(42.53746), pytest.approx(11.785218))
        assert "without row 10" in mean.reason
        assert "row 10 counted as 0" in spread.reason

    def test_another_printed_mean_changes_the_verdict(self) -> None:
        right = dict(PUBLISHED.table_4_1) | {"rho": (PrintedNumber("42.5375"), PrintedNumber("11.7852"))}
        assert one(table_4_1(replace(PUBLISHED, table_4_1=right)), "Table 4.1", "mean of ρ").verdict == "agrees"
        wrong = dict(PUBLISHED.table_4_1) | {"rho": (PrintedNumber("41.0000"), PrintedNumber("11.7852"))}
        value = one(table_4_1(replace(PUBLISHED, table_4_1=wrong)), "Table 4.1", "mean of ρ")
        assert "leaving out any one" in value.reason

    def test_another_row_changes_the_mean(self) -> None:
        rows = tuple(replace(r, kx=0.9) if (r.table, r.row) == ("4.2", 1) else r for r in PUBLISHED.rows)
        assert one(table_4_1(replace(PUBLISHED, rows=rows)), "Table 4.1", "mean of kx").verdict == "differs"

    def test_the_cubics_come_back_at_the_applied_voltages_only(self) -> None:
        part = equations(PUBLISHED)
        recovered = [f for f in part.compared if f.artefact in ("(4.6)", "(4.7)", "(4.8)")]
        assert len(recovered) == 12
        assert {f.verdict for f in recovered} == {"agrees"}
        assert max(abs(f.ours / f.published - 1) for f in recovered) < 4e-4
        off = one(part, "Printed voltages", "kw at the printed 0.88 V")
        assert off.ours - off.published == pytest.approx(-1.47, abs=0.005)
        ten = one(part, "(4.8) from all ten rows", "ρ")
        assert ten.ours / ten.published - 1 == pytest.approx(-0.0132, abs=2e-4)
        assert "3.674 V" in one(part, "Range of (4.6) to (4.8)", "the highest").reason

    def test_an_altered_coefficient_differs(self) -> None:
        cubics = dict(PUBLISHED.cubics) | {"kw": (*PUBLISHED.cubics["kw"][:3], PrintedNumber("3.6190"))}
        part = equations(replace(PUBLISHED, cubics=cubics))
        assert one(part, "(4.7)", "kw: coefficient of v³").verdict == "differs"
        assert one(part, "(4.7)", "kw: coefficient of v²").verdict == "agrees"


class TestChapter5:
    def test_the_peaks(self, fifth: StudyPart) -> None:
        for case, peak in (("case 1", 45.5340), ("case 2", 27.2081), ("case 3", 3.5215)):
            value = one(fifth, "Figure 5.4", f"peak of the first floor, {case}")
            assert (value.ours, value.verdict) == (pytest.approx(peak, rel=2e-4), "differs")
        assert "4.9005" in one(fifth, "Figure 5.4", "peak of the first floor, case 1").reason

    def test_the_unit_slip_is_likely_and_not_proven(self, fifth: StudyPart) -> None:
        value = one(fifth, "Figure 5.4", "a unit slip")
        assert "likely, not proven" in value.quantity
        two, three = (float(word) for word in str(value.ours).replace(" mm", "").split(" and "))
        assert (two, three) == (pytest.approx(216.34, abs=0.05), pytest.approx(219.79, abs=0.05))

    def test_the_percentages_from_the_printed_peaks(self, fifth: StudyPart) -> None:
        compared = [one(fifth, "Section 5.2", f"reduction in case {k}") for k in (2, 3)]
        assert [round(float(f.ours), 2) for f in compared] == [2.82, 9.69]
        assert {f.verdict for f in compared} == {"differs"}

    def test_the_sign_of_the_output(self, fifth: StudyPart) -> None:
        erratum = next(e for e in fifth.errata if e.place == "(5.6)")
        assert erratum.correct == "D_y = +M⁻¹Λ"

    def test_other_printed_peaks_change_the_verdicts(self) -> None:
        peaks = (PrintedNumber("45.5340"), PrintedNumber("27.2080"), PrintedNumber("201.5243"))
        fifth = chapter_5(replace(PUBLISHED, peaks=peaks, reductions=(PrintedNumber("40.25"), PrintedNumber("13.66"))))
        assert one(fifth, "Figure 5.4", "peak of the first floor, case 1").verdict == "agrees"
        assert one(fifth, "Figure 5.4", "peak of the first floor, case 2").verdict == "agrees"
        assert one(fifth, "Figure 5.4", "peak of the first floor, case 3").verdict == "differs"
        assert one(fifth, "Section 5.2", "reduction in case 2").verdict == "agrees"
        assert "not supported" in one(fifth, "Figure 5.4", "a unit slip").quantity


class TestWithoutData:
    def test_what_needs_the_files_has_no_number(self, bare: Study) -> None:
        needing = [
            f for f in bare.compared if f.artefact in ("Table 4.2", "Table 4.5", "14.81 %", "21.71 %", "Table A.2")
        ]
        assert len(needing) >= 100
        assert {f.verdict for f in needing} == {"cannot be checked"}
        assert {f.ours for f in needing} == {None}
        assert all("dampyr datasets fetch labcontrol" in f.reason for f in needing)

    def test_the_rest_is_done(self, bare: Study) -> None:
        assert one(bare, "Table 4.1", "mean of kx").verdict == "agrees"
        assert one(bare, "(4.7)", "kw: coefficient of v³").verdict == "agrees"
        assert one(bare, "Figure 5.4", "peak of the first floor, case 1").ours == pytest.approx(45.534, rel=2e-4)

    def test_what_was_left_out_is_said(self, bare: Study) -> None:
        assert bare.data is None
        assert "dampyr datasets fetch labcontrol" in bare.left_out[0]
        assert bare.page is not None
        assert "dampyr datasets fetch labcontrol" in bare.page.read_text("utf-8")

    def test_every_artefact_is_on_the_page(self, bare: Study) -> None:
        assert bare.page is not None
        text = bare.page.read_text("utf-8")
        assert [name for name in ARTEFACTS if name not in text] == []
        assert set(ARTEFACTS) <= set(bare.artefacts)

    def test_a_folder_that_was_named_must_hold_the_campaign(self, tmp_path: Path) -> None:
        with pytest.raises(MissingData, match="datasets fetch"):
            raminelli_2020.reproduce(tmp_path)


class TestOnTheFiles:
    def test_every_row_is_there(self, study: Study) -> None:
        for table in ("4.2", "4.3", "4.4", "4.5"):
            compared = study.artefacts[f"Table {table}"]
            assert len([f for f in compared if f.quantity.startswith("row ")]) == 50
        lost = {f.quantity.partition(":")[0] for f in study.artefacts["Table 4.4"] if f.verdict == "cannot be checked"}
        assert lost == {"row 2", "row 4"}
        assert list(study.left_out) == [
            "table 4.4, row 2: no file in the folder",
            "table 4.4, row 4: no file in the folder",
        ]

    def test_row_10_of_table_4_3_is_mislabelled(self, study: Study) -> None:
        frequency = one(study, "Table 4.3", "row 10: frequency")
        assert (frequency.verdict, frequency.ours) == ("differs", pytest.approx(0.675, abs=0.002))
        assert "ensaio.vali.1" in frequency.reason
        assert one(study, "Table 4.3", "row 10: displacement").ours == pytest.approx(16.3, abs=0.1)
        moved = [f for f in study.compared if f.artefact.startswith("Table 4.") and f.unit in ("Hz", "mm")]
        assert [f.quantity for f in moved if f.verdict == "differs"] == ["row 10: displacement", "row 10: frequency"]

    def test_means_of_the_modified_method(self, study: Study) -> None:
        for table, rows in (("4.3", 10), ("4.4", 8), ("4.5", 10)):
            for name in ("kx", "kw"):
                assert one(study, f"Table {table}", f"mean of {name} over {rows} rows").verdict == "agrees"
            assert one(study, f"Table {table}", f"mean of ρ over {rows} rows").verdict == "differs"

    def test_the_published_errors(self, study: Study) -> None:
        at_0 = one(study, "14.81 %", "mean of L1")
        assert (at_0.ours, at_0.verdict) == (pytest.approx(10.9, abs=0.1), "differs")
        run = one(study, "21.71 %", "L1 (3.1) of the cubics, the validation run")
        assert (run.ours, run.verdict) == (pytest.approx(7.6, abs=0.5), "differs")
        assert one(study, "21.71 %", "mean error over the validation runs").ours is None

    def test_figure_4_3(self, study: Study) -> None:
        assert one(study, "Figure 4.3", "frequency").verdict == "agrees"
        assert one(study, "Figure 4.3", "maximal displacement").verdict == "agrees"
        assert one(study, "Figure 4.3", "sampling rate").ours == pytest.approx(100.0)

    def test_the_laboratorys_motion_is_the_built_in_one(self, study: Study, ground_motion_folder: Path) -> None:
        assert (ground_motion_folder / "ElCentroData.mat").is_file()
        assert one(study, "Figure 5.1", "the motion's samples").verdict == "agrees"

    def test_page_and_json(self, study: Study) -> None:
        assert study.page is not None
        text = study.page.read_text("utf-8")
        assert [name for name in ARTEFACTS if name not in text] == []
        assert text.count("<svg") == 12
        output = json.loads((study.page.parent / "reproduce.json").read_text("utf-8"))
        assert len(output["compared"]) == len(study.compared)
        assert output["artefacts"]["(4.7)"] == {"verdict": "agrees", "agrees": 4, "differs": 0, "cannot be checked": 0}

    def test_every_verdict_of_a_number_follows_from_it(self, study: Study) -> None:
        """A number without a value of ours is never judged, and one with a value always is."""
        for f in study.compared:
            assert (f.ours is None) == (f.verdict == "cannot be checked"), f
            assert f.reason


def test_a_folder_with_few_files(campaign_folder: Path, tmp_path: Path) -> None:
    """What is not there is not guessed: one file at 0 V, no joint model, no validation run."""
    for name in ("campaign.csv", "ensaio5.1.mat"):
        shutil.copy(campaign_folder / name, tmp_path / name)
    few = raminelli_2020.reproduce(tmp_path)
    assert one(few, "Table 4.2", "row 5: frequency").verdict == "agrees"
    assert one(few, "Table 4.2", "row 6: frequency").ours is None
    assert one(few, "21.71 %", "mean error").ours is None
    assert len(few.left_out) == 40
