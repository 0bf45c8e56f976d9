"""Laws of the unknowns: ties, fixed numbers, inputs that they can carry, and ends at a limit."""

import numpy as np
import pytest
from tests.identification.campaign_of_dahl import TRUTH
from tests.identification.synthetic import DAHL, sine
from tests.models.exponent_of_bouc_wen import of_exponent

from dampyr.errors import InputError
from dampyr.identification import fit
from dampyr.identification.fits.least_squares import prepared
from dampyr.identification.search.parametrisation import Column
from dampyr.models import Damper, Interpolation
from dampyr.models.laws import look_up, polynomial_table
from dampyr.units import Quantity


def test_a_tied_parameter_takes_the_law_of_the_other_and_is_counted_once() -> None:
    laws = {"dahl.kx": 800.0, "dahl.kw": Interpolation((0.0, 1.0), (60.0, 90.0)), "dahl.rho": 3000.0}
    laws |= {"hyperbolic_tangent.c": 0.0, "hyperbolic_tangent.v0": 0.01, "hyperbolic_tangent.s": 0.0}
    laws |= {"hyperbolic_tangent.ft": Interpolation((0.0, 1.0), (60.0, 90.0))}
    truth = Damper("dahl + hyperbolic_tangent", laws)
    records = [sine(truth, u, f"{u:g}-{k}", 0.004 + 0.003 * k) for u in (0.0, 1.0) for k in range(3)]
    fit_result = fit(
        records,
        "dahl + hyperbolic_tangent",
        fixed={"hyperbolic_tangent.c": 0.0, "hyperbolic_tangent.s": 0.0},
        tied={"hyperbolic_tangent.ft": "dahl.kw"},
    )
    assert not any("ft" in label for label in fit_result.parameters)
    assert fit_result.damper is not None
    assert fit_result.damper.all_laws["hyperbolic_tangent.ft"](1.0) == pytest.approx(90.0, rel=1e-4)
    assert fit_result.damper.all_laws["dahl.kw"](0.0) == pytest.approx(60.0, rel=1e-4)
    names = list(fit_result.damper.all_laws)
    sizes = [len(law.coefficients) for law in fit_result.damper.all_laws.values()]
    starts = np.cumsum([0, *sizes])
    kw, ft = starts[names.index("dahl.kw")], starts[names.index("hyperbolic_tangent.ft")]
    assert (
        fit_result.damper.covariance[kw, kw]
        == fit_result.damper.covariance[ft, ft]
        == fit_result.damper.covariance[kw, ft]
    )


def test_voltages_that_differ_by_rounding_share_a_value_of_the_law_and_each_is_modelled() -> None:
    truth = Damper("dahl", TRUTH)
    records = [
        sine(truth, u, f"{k}", 0.005 + 0.001 * k, offset=0.0) for k, u in enumerate((0.0, 2.0, 2.0000004, 2.0, 0.0))
    ]
    fit_result = fit(records, "dahl")
    assert [label for label in fit_result.parameters if label.startswith("dahl.kw")] == [
        "dahl.kw @ 0 V",
        "dahl.kw @ 2 V",
    ]
    assert fit_result.parameters["dahl.kw @ 2 V"] == pytest.approx(380.0, rel=1e-5)
    assert max(one.l1 for one in fit_result.scores.values()) < 1e-4


def test_fixed_parameters_stay_and_are_no_longer_estimated() -> None:
    truth = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})
    fit_result = fit(sine(truth, 0.0, noise=1.0), "dahl", fixed={"dahl.rho": 2500.0})
    assert "dahl.rho" not in fit_result.parameters
    assert fit_result.damper is not None
    assert fit_result.damper.at(0.0).rho == 2500.0
    assert fit_result.damper.covariance[2, 2] == 0.0


def test_of_two_dashpots_one_is_held_and_the_note_says_which() -> None:
    truth = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})
    fixed = {"hyperbolic_tangent.ft": 1e-3, "hyperbolic_tangent.v0": 0.01, "hyperbolic_tangent.s": 0.0}
    fit_result = fit(sine(truth, 0.0, noise=1.0), "dahl + hyperbolic_tangent", fixed=fixed)
    assert "hyperbolic_tangent.c" not in fit_result.parameters
    assert fit_result.parameters["dahl.kx"] == pytest.approx(900.0, rel=0.02)
    assert np.isfinite(fit_result.stderr["dahl.kx"])
    assert any(
        note.startswith("hyperbolic_tangent.c is held at 0, as dahl.kx") for note in map(str, fit_result.findings)
    )


def test_laws_that_the_voltages_cannot_carry_are_refused() -> None:
    damper = Damper("dahl", TRUTH)
    records = [sine(damper, u, f"{u}") for u in (0.0, 1.0)]
    with pytest.raises(InputError, match=r"2 inputs cannot give a polynomial of degree 2 .* lower it to 1"):
        fit(records, "dahl", laws="polynomial:2")
    with pytest.raises(InputError, match="'spline' is an unknown law"):
        fit(records, "dahl", laws="spline")


AT_LEAST_ONE = Quantity("", low=1.0, high=50.0)


def looked_up(damper: Damper, inputs: np.ndarray) -> np.ndarray:
    """n at these inputs as a kernel of a structure looks it up."""
    knots, coefficients = polynomial_table(damper)
    out = np.empty((inputs.size, len(knots)))
    for row, u in zip(out, inputs, strict=True):
        look_up(knots, coefficients, float(u), row)
    return out[:, list(damper.all_laws).index("bouc_wen.n")]


@pytest.mark.parametrize("draws", [100, pytest.param(300, marks=pytest.mark.prove)])
def test_a_fitted_line_that_ends_at_a_limit_makes_a_damper(draws: int) -> None:
    rng = np.random.default_rng(0)
    for k in range(draws):
        low, high = np.sort(rng.uniform(0.0, 3.0, 2))
        ends = (1.0, rng.uniform(1.0, 3.0)) if k % 2 else (rng.uniform(1.0, 3.0), 1.0)
        column = Column("bouc_wen.n", AT_LEAST_ONE, "polynomial", (low, high))
        damper = of_exponent(column.law(np.array(ends), low, high))
        inputs = np.linspace(low, high, 50)
        values = damper.values(inputs)[:, -1]
        np.testing.assert_allclose(values, np.interp(inputs, (low, high), ends), rtol=1e-9)
        assert values.min() >= 1.0
        assert looked_up(damper, inputs).min() >= 1.0


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_a_fitted_polynomial_that_stands_at_a_limit_everywhere_makes_a_damper(degree: int) -> None:
    rng = np.random.default_rng(degree)
    for _ in range(50):
        knots = tuple(np.sort(rng.uniform(0.0, 3.0, degree + 1)))
        column = Column("bouc_wen.n", AT_LEAST_ONE, "polynomial", knots)
        damper = of_exponent(column.law(np.ones(degree + 1), knots[0], knots[-1]))
        values = damper.values(np.linspace(knots[0], knots[-1], 200))[:, -1]
        assert values.min() >= 1.0
        assert values.max() < 1.0 + 1e-6
        assert np.min(damper.all_laws["bouc_wen.n"].extremes()) >= 1.0


def test_a_ratio_that_may_be_zero_is_searched_in_its_logarithm() -> None:
    problem = prepared("modified_bouc_wen", [sine(DAHL, 0.0)])
    chosen = dict(zip([c.name.partition(".")[2] for c in problem.columns], problem.is_logarithmic, strict=True))
    assert [name for name, flag in chosen.items() if flag] == ["vc", "r", "rho", "sigma"]
    assert np.all(problem.inside(np.zeros(problem.size))[problem.is_logarithmic] > 0.0)
