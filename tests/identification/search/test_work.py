"""The work of a fit: evaluations times samples, the same on every machine."""

import pytest
from tests.identification.tangent_campaign import NAME, campaign

from dampyr.errors import InputError
from dampyr.identification import fit
from dampyr.models import available_parts


def test_every_part_of_the_catalogue_has_a_cost_and_work_counts_evaluations_times_samples() -> None:
    from dampyr.identification.fits.least_squares import prepared
    from dampyr.identification.search.work import COSTS, EVALUATION, Work

    assert sorted(COSTS) == sorted(available_parts())
    problem, work = prepared("dahl + spring", campaign(1)), Work()
    for _ in range(3):
        work.count(problem)
    samples = sum(piece.t.size for piece in problem.pieces)
    assert work.spent == pytest.approx(3 * (1e-9 * samples * (COSTS["dahl"] + COSTS["spring"]) + EVALUATION))


def test_a_fit_stops_where_its_work_is_spent_however_fast_the_machine() -> None:
    record = campaign(1)[0]
    stopped = fit(record, NAME, budget=1e-9)
    assert not stopped.converged
    assert stopped.reason == "did not converge: its share of the work was used up"
    whole = fit(record, NAME, budget=60.0)
    assert whole.converged
    assert 0.0 < stopped.outcome.work < whole.outcome.work < 60.0
    assert whole.parameters == fit(record, NAME).parameters
    with pytest.raises(InputError, match="budget = 0 s is not allowed; it must be greater than 0"):
        fit(record, NAME, budget=0.0)
