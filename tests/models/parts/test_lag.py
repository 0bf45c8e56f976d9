# A coil of resistance R and inductance L behind a ramp, a step and a sine of its command: closed forms.
"""The lag of the input behind its command."""

import numpy as np
import pytest
from tests.identification.search.test_normal_equations import numeric, somewhere
from tests.identification.synthetic import sine

from dampyr.errors import InputError
from dampyr.export import export
from dampyr.identification import FitOptions, fit
from dampyr.identification.fits.least_squares import prepared
from dampyr.identification.search.normal_equations import products
from dampyr.models import Damper, Polynomial
from dampyr.models.input_lag import lagged
from dampyr.records import Record

LAWS = {
    "bingham.c0": Polynomial((500.0, 300.0), 0.0, 3.0),
    "bingham.fc": Polynomial((40.0, 150.0), 0.0, 3.0),
    "bingham.v0": 0.004,
    "lag.tau": 0.03,
}


def path(n: int = 4000) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    t = np.linspace(0.0, 8.0, n)
    command = 1.0 + 0.9 * np.sign(np.sin(2 * np.pi * 0.7 * t))
    return t, 0.01 * np.sin(6 * t), 0.06 * np.cos(6 * t), command


@pytest.mark.usefixtures("plain")
def test_the_force_has_the_parameters_of_the_lagging_input() -> None:
    t, x, v, command = path()
    ours = Damper("bingham + lag", LAWS).force(t, x, voltage=command, velocity=v)
    same = Damper("bingham", {k: law for k, law in LAWS.items() if k != "lag.tau"})
    np.testing.assert_allclose(ours, same.force(t, x, voltage=lagged(t, command, 0.03), velocity=v), atol=1e-9)


@pytest.mark.usefixtures("plain")
def test_the_sums_of_a_fit_have_the_derivative_by_the_lag() -> None:
    """Against central differences of the modelled force, as in the proofs that fit it."""
    t, x, v, command = path(400)
    force = Damper("bingham + lag", LAWS).force(t, x, voltage=command, velocity=v)
    record = Record(time=t, displacement=x, velocity=v, force=force, voltage=command, name="steps")
    problem = prepared("bingham + lag", [record], FitOptions(laws={"bingham.v0": "constant", "*": "polynomial:1"}))
    point = somewhere(problem)
    table, sums = numeric(problem, point, 0), products(problem, point)[0].sum(axis=0)
    np.testing.assert_allclose(sums, table.T @ table, rtol=2e-4, atol=2e-5 * np.abs(table.T @ table).max())
    place = problem.locals + [column.name for column in problem.columns for _ in range(column.size)].index("lag.tau")
    assert sums[place, place] > 1e-6 * np.abs(np.diag(sums)).max()


@pytest.mark.prove
def test_a_fit_of_records_with_steps_of_the_command_gives_it_back() -> None:
    rng = np.random.default_rng(1)
    t, x, v, command = path()
    force = Damper("bingham + lag", LAWS).force(t, x, voltage=command, velocity=v) + rng.normal(0.0, 2.0, t.size)
    record = Record(time=t, displacement=x, velocity=v, force=force, voltage=command, name="steps")
    fit_result = fit(
        record,
        "bingham + lag",
        laws={"bingham.v0": "constant", "bingham.c0": "polynomial:1", "bingham.fc": "polynomial:1"},
    )
    assert fit_result.converged, fit_result.reason
    assert fit_result.parameters["lag.tau"] == pytest.approx(0.03, abs=4 * fit_result.stderr["lag.tau"])
    assert fit_result.stderr["lag.tau"] < 0.002
    assert fit_result.damper is not None


@pytest.mark.prove
def test_constant_inputs_say_nothing_about_it() -> None:
    truth = Damper("bingham", {"bingham.c0": 500.0, "bingham.fc": 90.0, "bingham.v0": 0.004})
    fit_result = fit(sine(truth, 0.0), "bingham + lag")
    assert np.isinf(fit_result.stderr["lag.tau"])


def test_what_cannot_be_is_said() -> None:
    with pytest.raises(InputError, match="must be a constant"):
        Damper("bingham + lag", LAWS | {"lag.tau": Polynomial((0.01, 0.01), 0.0, 3.0)})
    with pytest.raises(InputError, match=r"without\('lag'\)"):
        export(Damper("bingham + lag", LAWS), "c", ".", inverse=True)
