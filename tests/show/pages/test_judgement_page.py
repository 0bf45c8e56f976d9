"""The page of a judgement: verdicts first, then reasons, loops, criteria and every cycle."""

from pathlib import Path

import pytest
from tests.campaigns.specimen_folders import QUASI_STATIC, dahl, specimen_folder
from tests.show.pages.test_html_page import Reader

from dampyr.campaigns.judgement import DesignLevel, judge
from dampyr.show.pages.result_page import write_page


@pytest.mark.usefixtures("figures_not_rendered")
def test_it_names_criterion_limit_value_and_verdict_of_every_cycle_and_what_was_not_judged(tmp_path: Path) -> None:
    weak = specimen_folder(tmp_path / "weak", QUASI_STATIC, dahl(180.0, 4000.0), specimen="SN 2")
    missing = specimen_folder(tmp_path / "missing", QUASI_STATIC, dahl(300.0, 4000.0), states={1: "planned"})
    result = judge([weak, missing], "ntc_2018_viscous", [DesignLevel(0.004, largest_force=300.0, energy=4.5)])
    html = write_page(result, tmp_path / "page.html").read_text("utf-8")
    reader = Reader(html)
    assert reader.open == []
    assert reader.inside("h1") == ["Judged by ntc_2018_viscous"]
    assert reader.inside("h2")[:6] == [
        "In short", "What was not judged", "The levels", "The loops", "The criteria", "Every cycle of SN 2",
    ]  # fmt: skip
    assert "1 failed, 1 not judged." in " ".join(reader.inside("p"))
    assert all(mark in html for mark in ("✗ failed", "? not judged"))
    assert "The test was not run." in reader.inside("td")
    cells = reader.inside("td")
    assert cells.count("NTC 2018 [11.9.7]") == 1 + 5  # of the criteria, and of five cycles
    assert "NTC 2018 Tab. 11.9.III, supply: from below only" in cells
    assert "No cycle was judged." in reader.inside("p")
    assert html.count("<svg") == 1


@pytest.mark.usefixtures("figures_not_rendered")
def test_two_folders_of_one_specimen_are_told_apart(tmp_path: Path) -> None:
    folders = [specimen_folder(tmp_path / name, QUASI_STATIC, dahl(300.0, 4000.0)) for name in ("first", "again")]
    reader = Reader(write_page(judge(folders, "ntc_2018_viscous"), tmp_path / "page.html").read_text("utf-8"))
    assert [text for text in reader.inside("h2") if "Every cycle" in text] == [
        f"Every cycle of SN 1, {folder}" for folder in folders
    ]
