"""The campaign as this run needs it: every file read once, measured once and identified once by each method."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dampyr.identification import Fit, fit, plastic_region
from dampyr.identification.limit_cycle_methods.plastic_region import PlasticRegion
from dampyr.records import Record, cycle_bounds, measure
from dampyr.records.checks.label_checks import disagreements
from dampyr.records.cycle_analysis.cycles import turning_points
from dampyr.records.cycle_analysis.measure import Measured
from dampyr.records.files.campaign_folder import CampaignRow, campaign_rows, read_row

Array = NDArray[np.float64]
Progress = Callable[[str, float], None]
JOINT = "dahl + hyperbolic_tangent + spring + delay"
JOINT_LAWS = {"dahl.rho": "constant", "delay.tau": "constant"}  # one pre-sliding path, and one lag: the rig's
JOINT_BANDWIDTH = 15.0  # Hz
JOINT_FIXED = {"hyperbolic_tangent.c": 0.0, "hyperbolic_tangent.s": 0.0}  # one dashpot, that of dahl; no shift


@dataclass(frozen=True)
class PublishedTest:
    """One test: its record, what it measures, and the viscous Dahl model by both methods (None for a validation test).

    ``slopes`` (m,) are a/kw in 1/m from the two samples on either side of each zero crossing of theta.
    """

    row: CampaignRow
    record: Record
    measured: Measured
    plastic: PlasticRegion
    least_squares: Fit | None
    slopes: Array
    disagreements: tuple[str, ...]


@dataclass(frozen=True)
class PublishedCampaign:
    """All tests of a folder, the rows that have no file there, and one model fitted to all records of the tables."""

    folder: Path
    tests: tuple[PublishedTest, ...]
    absent: tuple[CampaignRow, ...]
    joint: Fit | None

    def table(self, table: str) -> list[PublishedTest]:
        """The tests of one table that have a file."""
        return [test for test in self.tests if test.row.table == table]

    def test(self, table: str, row: int) -> PublishedTest | None:
        """The test of one row, None without a file."""
        return next((t for t in self.tests if t.row.table == table and t.row.row == row), None)

    @property
    def validation(self) -> list[PublishedTest]:
        """The tests that no fit saw."""
        return [test for test in self.tests if test.row.role == "validation"]


def load(folder: Path, progress: Progress) -> PublishedCampaign:
    """Read and identify; raises FileError where a file is not what its table says."""
    rows = campaign_rows(folder)
    present = [row for row in rows if row.file is not None]
    tests = []
    for k, row in enumerate(present):
        progress("identifying each record", k / len(present))
        tests.append(_test(row))
    progress("identifying each record", 1.0)
    absent = tuple(row for row in rows if row.file is None)
    return PublishedCampaign(folder, tuple(tests), absent, _joint(tests, progress))


def _test(row: CampaignRow) -> PublishedTest:
    record = read_row(row)
    plastic = plastic_region(record)
    alone = fit(record, "dahl") if row.role == "fit" else None
    slopes = crossing_slopes(record, plastic)
    return PublishedTest(row, record, measure(record), plastic, alone, slopes, tuple(disagreements(record)))


def _joint(tests: list[PublishedTest], progress: Progress) -> Fit | None:
    """One model for all voltages, fitted to the records of all tables together; None without records at two voltages."""
    records = [test.record for test in tests if test.row.role == "fit"]
    if len({record.input_value for record in records}) < 2:
        return None
    stage = "one model for all records"
    progress(stage, 0.0)
    fit_result = fit(
        records,
        JOINT,
        laws=JOINT_LAWS,
        fixed=JOINT_FIXED,
        bandwidth=JOINT_BANDWIDTH,
        progress=lambda _, done: progress(stage, done),
    )
    progress(stage, 1.0)
    return fit_result


def crossing_slopes(record: Record, plastic: PlasticRegion) -> Array:
    """a/kw in 1/m, (m,): (2.7) by the two samples next to each zero of theta, at each passage after a turning point."""
    assert record.velocity is not None
    bounds, points = cycle_bounds(record), turning_points(record)
    points = points[(points >= bounds[0][0]) & (points <= bounds[-1][1])]
    theta = record.force - plastic.offset - plastic.kx * record.velocity
    slopes = []
    for first, last in pairwise(points):
        side = np.sign(record.displacement[last] - record.displacement[first])
        x, q = side * record.displacement[first : last + 1], side * theta[first : last + 1]
        up = np.flatnonzero((q[:-1] < 0) & (q[1:] >= 0))
        if up.size and x[up[0] + 1] > x[up[0]]:
            slopes.append((q[up[0] + 1] - q[up[0]]) / (x[up[0] + 1] - x[up[0]]))
    return np.array(slopes) / plastic.kw
