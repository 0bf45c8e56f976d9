"""The page of the study: every artefact with its verdict, slips, and what was left out."""

import json
from pathlib import Path

import pytest
from tests.studies.raminelli_2020.small_study import study

from dampyr.studies.raminelli_2020.study_page import errata, html, summary, write


def test_the_summary_has_a_line_for_each_artefact_with_the_reason_of_its_verdict() -> None:
    _, figure, table, left_out = summary(study())
    assert [label.get_text() for label in figure.figure.axes[0].get_yticklabels()] == ["Table 1", "(2)"]
    rows = {row[0]: row for row in table.rows}
    assert list(rows) == ["Table 1", "(2)", "Figure 3"]
    assert [row[-1].kind for row in rows.values()] == ["differs", "agrees", "cannot be checked"]
    assert rows["Table 1"][-1].text.startswith("1 of 2: mean of b")
    assert "no files" in rows["Figure 3"][-1].text
    assert left_out.text == "left out: all files"


def test_slips_say_where_and_why() -> None:
    [row] = errata(study().errata).rows
    assert row == ["(9)", "-a", "+a", "the sign of (8)"]


def test_page_and_json_have_the_same_numbers(tmp_path: Path) -> None:
    written = write(study(), tmp_path)
    assert written.page == tmp_path / "reproduce.html"
    text = written.page.read_text("utf-8")
    for words in ("Table 1", "mean of b", "Slips of the text", "the sign of (8)", "all files", "were not there"):
        assert words in text
    output = json.loads((tmp_path / "reproduce.json").read_text("utf-8"))
    assert output["artefacts"]["Table 1"] == {"verdict": "differs", "agrees": 1, "differs": 1, "cannot be checked": 0}
    assert [value["ours"] for value in output["compared"]] == [2.0, pytest.approx(3.3), 5.0, None]
    assert "Nothing." not in html(study())
