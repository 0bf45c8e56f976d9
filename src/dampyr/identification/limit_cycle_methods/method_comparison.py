r"""The two graphical methods of Raminelli (2020) on records, beside least squares.

`limit_cycle` needs the loading branch of one cycle without offset, and the viscous coefficient where the motion is a sine. Of
a record offset and :math:`k_x` are those of the straight lines of its plastic region (`plastic_region`), and the branch is the
mean over its whole cycles, from each lower turning point to the next upper one, on a grid of displacements.

Both methods take single points off a loop. What that costs is measured: the L1 ratio of a free run of the damper that they
give, and that of a fit by least squares to the same record.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dampyr.argument_kinds import RECORDS, Argument, check_kinds
from dampyr.config import Choices
from dampyr.errors import InputError
from dampyr.findings import Finding, handed_on
from dampyr.identification.fits.fit_options import FitOptions
from dampyr.identification.fits.least_squares import fit_model
from dampyr.identification.limit_cycle_methods.limit_cycle import LimitCycle, limit_cycle
from dampyr.identification.limit_cycle_methods.plastic_region import plastic_region
from dampyr.identification.scoring.score import Score, score, score_or_reason
from dampyr.models import Damper
from dampyr.origin import Origin, combined
from dampyr.records import Record, cycle_bounds, nominal_inputs, with_velocity
from dampyr.records.files.campaign_folder import RecordsOrPaths, as_records
from dampyr.shown import Shown

Array = NDArray[np.float64]
METHODS = Choices({"limit-cycle": "(2.5) to (2.9) on the mean loading branch", "plastic-region": "(4.1) and (2.7)"})
GRID = 2000  # displacements of a loading branch: its rise after a turning point takes some hundredths of the stroke
LOCAL = 9  # of them in each local polynomial


@dataclass(frozen=True)
class MethodResult:
    """What a method gives of one record: ``numbers`` of the viscous Dahl model (kx N s/m, kw N, rho 1/m), those of least
    squares, and the score of a free run by each. Where one gives nothing, its score is the reason."""

    record: str
    input_value: float | None
    numbers: dict[str, float]
    score: Score | str
    least_squares: dict[str, float]
    least_squares_score: Score | str


@dataclass(frozen=True, repr=False)
class MethodComparison(Shown):
    """Result of `compare_method`: a row a record."""

    method: str
    records: tuple[Record, ...]
    results: tuple[MethodResult, ...]

    @property
    def origin(self) -> Origin:
        """That of the records together."""
        return combined(record.origin for record in self.records)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What is wrong or in doubt in the records."""
        return handed_on(self.records)


def compare_method(
    records: RecordsOrPaths,
    method: str,
    bandwidth: float | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> MethodComparison:
    """The viscous Dahl model of each record by a graphical method, beside least squares.

    Parameters
    ----------
    records
        one record, or several: each by itself.
    method
        ``"limit-cycle"`` or ``"plastic-region"``.
    bandwidth
        of the velocity that is derived from the displacement, Hz; by default the recorded velocity where there is one.
    progress
        called with what is being done, and the fraction of it that is done.

    Returns
    -------
    MethodComparison
        a row a record; what a record does not give is a reason in its row.

    Raises
    ------
    InputError
        an unknown method, or no records.

    Examples
    --------
    >>> import numpy as np
    >>> import dampyr as dp
    >>> damper = dp.studies.raminelli_2020.damper()
    >>> t = np.linspace(0.0, 4.0, 4001)
    >>> x = 0.008 * np.sin(2 * np.pi * t)
    >>> record = dp.records.Record(t, x, damper.force(t, x, voltage=1.98), voltage=1.98)
    >>> (row,) = dp.identification.compare_method(record, "plastic-region").results
    >>> abs(row.numbers["kw"] / row.least_squares["kw"] - 1.0) < 0.01
    True
    """
    records = as_records(records)
    check_kinds("compare_method", Argument("records", records, (Record,), RECORDS, several=True))
    METHODS.check("method", method)
    options = FitOptions(bandwidth=bandwidth)
    nominal = tuple(nominal_inputs(records))
    if not nominal:
        raise InputError("there are no records to identify from; give one or more")
    results = []
    for k, record in enumerate(nominal):
        if progress:
            progress(f"by {method}", k / len(nominal))
        results.append(_compare_record(record, method, options))
    return MethodComparison(method, nominal, tuple(results))


def loading_branch(record: Record) -> tuple[Array, Array, Array]:
    """Displacement m, force N and velocity m/s, (2000,), of the mean loading branch of a record with a velocity."""
    assert record.velocity is not None
    x = record.displacement
    branches = []
    for first, last in cycle_bounds(record):
        lowest = first + int(np.argmin(x[first : last + 1]))
        highest = lowest + int(np.argmax(x[lowest : last + 1]))
        rising = np.maximum.accumulate(
            x[lowest : highest + 1]
        )  # samples that noise puts below an earlier one are left out
        places = lowest + np.flatnonzero(np.diff(rising, prepend=-np.inf) > 0.0)
        if places.size > GRID // 200:
            branches.append(places)
    if not branches:
        raise InputError(f"{record.name}: no cycle has a loading branch; give at least one whole cycle")
    ends = np.array([[x[places[0]], x[places[-1]]] for places in branches])
    low, high = (float(end) for end in np.median(ends, axis=0))
    grid = np.linspace(low, high, GRID)
    force, velocity = (
        np.mean([np.interp(grid, x[places], channel[places]) for places in branches], axis=0)
        for channel in (record.force, record.velocity)
    )
    return grid, force, velocity


def limit_cycle_of(record: Record) -> LimitCycle:
    """`limit_cycle` on the mean loading branch of a record with a velocity, with offset and kx of its plastic region."""
    plastic = plastic_region(record)
    x, force, velocity = loading_branch(record)
    return limit_cycle(x, force - plastic.offset, velocity, kx=plastic.kx, points=LOCAL)


def _compare_record(record: Record, method: str, options: FitOptions) -> MethodResult:
    numbers: dict[str, float] = {}
    moving = record
    if record.velocity is None or options.bandwidth is not None:
        moving = with_velocity(record, options.bandwidth)
    try:
        graphical = limit_cycle_of(moving) if method == "limit-cycle" else plastic_region(moving)
        numbers = {"kx": graphical.kx, "kw": graphical.kw, "rho": graphical.rho}
        by_method: Score | str = score(Damper("dahl", numbers), moving)
    except InputError as problem:
        by_method = str(problem)
    fit = fit_model("dahl", record, options)
    least = {name.partition(".")[2].partition(" @")[0]: value for name, value in fit.parameters.items()}
    by_least_squares = fit.reason if fit.damper is None else score_or_reason(fit.damper, record)
    return MethodResult(record.name, record.input_value, numbers, by_method, least, by_least_squares)
