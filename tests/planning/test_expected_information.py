"""What is expected of records agrees with what a fit to them says."""

from itertools import pairwise

import numpy as np
import pytest
from tests.identification.test_coverage import TESTED, as_measured
from tests.planning.laboratory import DAHL

from dampyr.campaigns.steps.voltage_steps import VoltageSteps
from dampyr.errors import InputError
from dampyr.identification import Fit, fit
from dampyr.planning.expected_information import (
    assumed_spread,
    expected,
    expected_information,
    expected_record,
    layout,
    learned,
)
from dampyr.rig import RigSettings


@pytest.fixture(scope="module")
def fitted() -> Fit:
    """Six records at each voltage with a gain of 3 % and coloured noise of 4 %."""
    rng = np.random.default_rng(4)
    return fit([as_measured(u, f"{u:g}V-{k}", rng) for u in TESTED for k in range(6)], "dahl")


def test_degrees_of_freedom_are_those_of_the_fit(fitted: Fit) -> None:
    assert fitted.damper is not None
    plan = layout(fitted.damper, [p.u for p in fitted.problem.pieces])
    assert plan.labels == [*fitted.parameters]
    spread, records = learned(fitted, plan)
    errors = expected(plan, records, spread)
    np.testing.assert_allclose(errors.freedom, [fitted.freedom[label] for label in plan.labels], rtol=0.02)


def test_the_spread_of_records_is_estimated_from_a_fit(fitted: Fit) -> None:
    assert fitted.damper is not None
    plan = layout(fitted.damper, [p.u for p in fitted.problem.pieces])
    spread, records = learned(fitted, plan)
    assert spread.share == pytest.approx(0.04, rel=0.25)
    gain = np.sqrt(spread.deviations[plan.names.index("dahl.kw")][plan.names.index("dahl.kw")])
    assert gain == pytest.approx(0.03, rel=0.5)
    errors = expected(plan, records, spread)
    spans = fitted.intervals()
    halves = [0.5 * (spans[label][1] - spans[label][0]) / fitted.parameters[label] for label in plan.labels]
    ratio = np.exp(np.mean(np.log(halves / errors.half)))
    assert 0.75 < ratio < 1.3, ratio


def test_more_records_make_narrower_intervals_and_two_make_none() -> None:
    rig = RigSettings()
    step = VoltageSteps(0.005, 1.5, TESTED, hold=2.0)
    record = expected_record(step.drive(rig), DAHL, rig, "steps")
    plan = layout(DAHL, [np.asarray(record.voltage)])
    spread = assumed_spread(plan)
    one = expected_information(plan, record, spread)
    halves = [expected(plan, [one] * n, spread).half for n in (2, 4, 8, 16)]
    assert np.all(np.isinf(halves[0]))
    for before, after in pairwise(halves[1:]):
        assert np.all(after < before)
    assert np.all(np.isfinite(expected(plan, [one] * 2, spread, open_ends=True).half))


def test_nothing_to_determine_is_refused() -> None:
    with pytest.raises(InputError, match="every parameter is fixed"):
        layout(DAHL, [0.0, 1.0], fixed={"dahl.kx": 800.0, "dahl.kw": 50.0, "dahl.rho": 2e4})
