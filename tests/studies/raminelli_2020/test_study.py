"""Raminelli (2020) run again as a whole, with the campaign and without."""

import json
import shutil
from pathlib import Path

import pytest
from tests.studies.raminelli_2020.artefact_values import one

from dampyr.errors import MissingData
from dampyr.studies import raminelli_2020
from dampyr.studies.raminelli_2020.study import Study

ARTEFACTS = (
    "Figure 2.2", "Figure 2.3", "Figure 2.4", "Section 2.4, step 2", "Section 2.4, steps 3 to 5", "Table 4.1", "Table 4.2",
    "Table 4.3", "Table 4.4", "Table 4.5", "(4.6)", "(4.7)", "(4.8)", "14.81 %", "21.71 %", "Figure 4.1", "Figure 4.2",
    "Figure 4.3", "Figure 4.4", "Figure 5.1", "Figure 5.4", "Section 5.2",
)  # fmt: skip


@pytest.fixture(scope="module")
def study(campaign_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Study:
    """The study on the real files."""
    return raminelli_2020.reproduce(campaign_folder, tmp_path_factory.mktemp("study"))


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


@pytest.mark.prove  # every file is read and identified
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
        assert text.count("<svg") == 13
        output = json.loads((study.page.parent / "reproduce.json").read_text("utf-8"))
        assert len(output["compared"]) == len(study.compared)
        assert output["artefacts"]["(4.7)"] == {"verdict": "agrees", "agrees": 4, "differs": 0, "cannot be checked": 0}

    def test_every_verdict_of_a_number_follows_from_it(self, study: Study) -> None:
        """A number without a value of ours is never judged, and one with a value always is."""
        for f in study.compared:
            assert (f.ours is None) == (f.verdict == "cannot be checked"), f
            assert f.reason


@pytest.mark.prove
def test_a_folder_with_few_files(campaign_folder: Path, tmp_path: Path) -> None:
    """What is not there is not guessed: one file at 0 V, no joint model, no validation run."""
    for name in ("campaign.csv", "ensaio5.1.mat"):
        shutil.copy(campaign_folder / name, tmp_path / name)
    few = raminelli_2020.reproduce(tmp_path)
    assert one(few, "Table 4.2", "row 5: frequency").verdict == "agrees"
    assert one(few, "Table 4.2", "row 6: frequency").ours is None
    assert one(few, "21.71 %", "mean error").ours is None
    assert len(few.left_out) == 40
