"""What a fit shows: its numbers by input, in the units that people read, and its scores."""

import numpy as np
import pytest
from tests.show.fit_examples import DAHL

from dampyr.errors import InputError
from dampyr.identification import Fit
from dampyr.show.descriptions import description_of
from dampyr.show.identification.result import error_table, measured_and_fitted, number_of, parameter_table

REST = 100  # samples of half a second before the motion, which are not fitted


def test_a_row_is_a_parameter_and_a_column_an_input(joint: Fit) -> None:
    table = parameter_table(joint)
    assert table.columns == ("parameter", "unit", "0 V", "1 V", "2 V")
    by_name = {row[0]: row for row in table.rows}
    for name, unit, factor in (("dahl.kx", "N s/mm", 1e-3), ("dahl.kw", "N", 1.0), ("dahl.rho", "1/mm", 1e-3)):
        assert by_name[name][1] == unit
        for cell, u in zip(by_name[name][2:], (0, 1, 2), strict=True):
            value = float(str(cell).partition(" ")[0])
            assert value == pytest.approx(factor * joint.parameters[f"{name} @ {u} V"], rel=1e-3)
            if name != "dahl.rho":
                assert value == pytest.approx(factor * float(DAHL.laws[name](float(u))), rel=0.05)  # the truth


def test_errors_stand_before_the_naive_ones(joint: Fit) -> None:
    by_name = {row[0]: row for row in error_table(joint).rows}
    cell = str(by_name["dahl.kw"][3])
    error, naive = (float(text.strip("(),")) for text in cell.split()[:2])
    assert error == pytest.approx(joint.stderr["dahl.kw @ 1 V"], rel=0.06)
    assert naive == pytest.approx(joint.naive_stderr["dahl.kw @ 1 V"], rel=0.06)


def test_the_text_states_records_and_scores(joint: Fit) -> None:
    rows = dict(description_of(joint).rows)
    l1 = [score.l1 for score in joint.scores.values()]
    assert rows["records"] == f"6, {sum(record.n - REST for record in joint.records)} samples, at 0, 1, 2 V"
    assert rows["L1"].startswith(f"{100 * np.mean(l1):.3g} % on average, {100 * max(l1):.3g} % at worst")


def test_the_median_record_is_drawn_where_none_is_named(joint: Fit) -> None:
    l1 = [score.l1 for score in joint.scores.values()]
    k = number_of(joint, None)
    assert sum(value < l1[k] for value in l1) == len(l1) // 2
    name = joint.records[2].name
    x, v, force, models, drawn = measured_and_fitted(joint, name)
    assert drawn == name
    np.testing.assert_array_equal(force, joint.records[2].force[REST:])
    np.testing.assert_array_equal(models["fit"], joint.forces[2])
    assert len(x) == len(v) == len(force)
    with pytest.raises(InputError, match="'nobody' is not among the fitted records; choose from"):
        number_of(joint, "nobody")


def test_the_frame_is_in_si_units(joint: Fit) -> None:
    frame = joint.to_dataframe()
    assert frame.loc["dahl.kx @ 1 V", "unit"] == "N s/m"
    assert frame.loc["dahl.kx @ 1 V", "value"] == joint.parameters["dahl.kx @ 1 V"]
