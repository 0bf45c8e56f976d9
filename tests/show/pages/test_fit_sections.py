"""Tables and figures of a fit that several pages share."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.show.fit_examples import records

from dampyr.identification import Fit, fit
from dampyr.phrases import with_reach
from dampyr.show.pages.blocks import Text
from dampyr.show.pages.fit_sections import correlation_blocks, parameter_tables
from dampyr.show.pages.result_page import write_page


@pytest.mark.prove
def test_errors_of_one_or_two_records_are_labelled_and_give_no_interval(tmp_path: Path) -> None:
    fit_result = fit([*records((0.0,), 3), *records((2.0,), 2)], "dahl", laws={"dahl.rho": "constant"})
    values, _, errors = parameter_tables(fit_result)
    assert values.columns == ("parameter", "unit", "all inputs", "0 V", "2 V")
    by_name = {row[0]: row for row in values.rows}
    assert "±" in by_name["dahl.kx"][3]
    assert "no interval" in by_name["dahl.kx"][4]
    assert by_name["dahl.rho"][3:] == ["", ""]
    assert "±" in by_name["dahl.rho"][2]
    labelled = [row[4] for row in errors.rows if row[4]]
    assert all("within these records only" in cell for cell in labelled)
    assert len(labelled) == 2
    html = write_page(fit_result, tmp_path / "page.html").read_text("utf-8")
    assert "2 of these errors hold within these records only" in html
    assert "between-record variance is not estimated from 2 records" in html.lower()


def test_intervals_are_those_of_the_fit_in_the_units_of_people() -> None:
    fit_result = fit(records((1.0, 2.0), 3), "dahl")
    values, _, errors = parameter_tables(fit_result)
    row = next(row for row in values.rows if row[0] == "dahl.kx")
    label = "dahl.kx @ 1 V"
    low, high = fit_result.intervals()[label]
    shown = row[values.columns.index("1 V")]
    assert shown == with_reach(1e-3 * fit_result.parameters[label], 0.5e-3 * (high - low))
    assert row[1] == "N s/mm"
    error = next(row for row in errors.rows if row[0] == "dahl.kx")[errors.columns.index("1 V")]
    assert error == f"{1e-3 * fit_result.stderr[label]:.2g} ({1e-3 * fit_result.naive_stderr[label]:.2g})"


def test_strong_pairs_are_told_in_words(joint: Fit) -> None:
    m = len(joint.parameters)
    r = np.eye(m)
    r[0, 2] = r[2, 0] = -0.97
    r[1, 3] = r[3, 1] = 0.6
    names = list(joint.parameters)
    text = correlation_blocks(replace(joint, correlation=r))[0]
    assert isinstance(text, Text)
    assert f"{names[0]} and {names[2]} (−0.97)" in text.text
    assert names[1] not in text.text
    r[0, 2] = r[2, 0] = np.nan
    text = correlation_blocks(replace(joint, correlation=r))[0]
    assert isinstance(text, Text)
    assert f"beyond ±0.9; the strongest are {names[1]} and {names[3]} (0.60)" in text.text
