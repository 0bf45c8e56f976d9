"""The unknowns of a search: nuisances of the records beside the numbers, and their limits."""

import numpy as np
import pytest
from tests.identification.fitted_numbers import NUMBERS, gained, values
from tests.identification.synthetic import DAHL, sine

from dampyr.errors import InputError
from dampyr.identification import fit
from dampyr.identification.fits.least_squares import prepared
from dampyr.models import Damper


def test_gains_of_the_load_cell_come_back_relative_to_their_mean() -> None:
    gains = [1.04, 0.97, 1.02, 0.98, 1.0, 0.99]
    fit_result = fit(gained(gains, [1.0] * 6), "dahl", nuisances=("offset", "state", "gain"))
    assert fit_result.converged, fit_result.reason
    mean = float(np.exp(np.mean(np.log(gains))))
    ours = [n.gain for n in fit_result.nuisances.values()]
    np.testing.assert_allclose(ours, np.array(gains) / mean, rtol=2e-3)
    assert np.mean(np.log(ours)) == pytest.approx(0.0, abs=1e-6)
    np.testing.assert_allclose(values(fit_result), NUMBERS * [mean, mean, 1.0], rtol=0.01)
    assert fit_result.nuisance_spread["gain"] == pytest.approx(np.std(gains, ddof=1), rel=0.1)
    assert fit(gained(gains, [1.0] * 6), "dahl").nuisances["r0"].gain == 1.0


def test_temperatures_scale_the_viscosity_alone() -> None:
    warmth = [1.15, 0.9, 1.05, 0.95, 1.0, 0.97]
    fit_result = fit(gained([1.0] * 6, warmth), "dahl", nuisances=("offset", "state", "temperature"))
    mean = float(np.exp(np.mean(np.log(warmth))))
    np.testing.assert_allclose(
        [n.temperature for n in fit_result.nuisances.values()], np.array(warmth) / mean, rtol=0.02
    )
    assert fit_result.parameters["dahl.kx"] == pytest.approx(900.0 * mean, rel=0.01)
    plain = fit(gained([1.0] * 6, warmth), "dahl")
    assert fit_result.scores["r0"].l1 < 0.5 * plain.scores["r0"].l1


def test_states_and_offsets_can_be_left_out() -> None:
    record = sine(DAHL, 0.0, offset=0.0)
    fit_result = fit(record, "dahl", nuisances=())
    np.testing.assert_allclose(values(fit_result), NUMBERS, rtol=1e-5)
    assert fit_result.nuisances["test"].offset == 0.0
    assert fit_result.nuisances["test"].states["dahl.w"] == 0.0


def test_no_temperature_without_viscosity() -> None:
    records = [sine(Damper("spring", {"spring.k0": 900.0}), 0.0, f"r{k}") for k in range(2)]
    with pytest.raises(InputError, match="no parameter in N s/m"):
        fit(records, "spring", nuisances=("offset", "temperature"))


def test_an_elongation_begins_within_the_stroke_of_the_records() -> None:
    damper = Damper("dahl", {"dahl.kx": 800.0, "dahl.kw": 55.0, "dahl.rho": 2500.0})
    records = [sine(damper, 0.0, "small", 0.002), sine(damper, 0.0, "large", 0.011)]
    problem = prepared("modified_bouc_wen + delay", records)
    low, high = problem.local_limits
    stroke = max(float(np.ptp(one.x)) for one in problem.pieces)
    assert list(problem.composition.states) == ["modified_bouc_wen.w", "modified_bouc_wen.e"]
    np.testing.assert_allclose(low, [-np.inf, -1.0, -stroke])
    np.testing.assert_allclose(high, [np.inf, 1.0, stroke])
    assert stroke == pytest.approx(0.022, rel=0.02)
