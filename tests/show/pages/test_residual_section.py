"""The section on the residuals of a fit: its tables hold the numbers of the residual itself."""

import numpy as np
import pytest

from dampyr.identification import Fit
from dampyr.show.pages.blocks import FigureBlock
from dampyr.show.pages.residual_section import residual_section, size_table
from dampyr.show.table import Table


def test_the_tables_are_of_measured_minus_modelled_force(joint: Fit) -> None:
    [by_direction] = (block for block in residual_section(joint.residuals).blocks if isinstance(block, Table))
    sizes = size_table(joint.residuals)
    rows = {row[0]: row for row in sizes.rows}
    assert set(rows) == {record.name for record in joint.records}
    for k, piece in enumerate(joint.problem.pieces):
        residual = piece.force - joint.forces[k]
        row = dict(zip(sizes.columns, rows[piece.name], strict=True))
        assert row["rms"] == pytest.approx(float(np.std(residual)), rel=0.02)
        assert row["noise"] == pytest.approx(float(np.std(np.diff(residual)) / np.sqrt(2.0)), rel=0.05)
        assert row["stroke"] == pytest.approx(1e3 * float(np.ptp(piece.x)), rel=0.02)
    assert [row[0] for row in by_direction.rows[:2]] == ["out", "in"]
    for row in by_direction.rows[:2]:
        assert list(row[1::2]) == pytest.approx([0.0] * 3, abs=0.2)  # the model is complete
        assert list(row[2::2]) == pytest.approx([1.0] * 3, rel=0.1)  # N, of the noise that was added
    assert len(by_direction.columns) == 1 + 2 * 3  # mean and rms at three voltages


def test_there_are_three_figures(joint: Fit) -> None:
    figures = [block.figure for block in residual_section(joint.residuals).blocks if isinstance(block, FigureBlock)]
    assert [len(figure.axes) for figure in figures] == [
        3,
        1,
        3,
    ]  # over velocity, over lag, over input, stroke, frequency
