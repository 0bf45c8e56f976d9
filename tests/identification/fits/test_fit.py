"""Least-squares identification: the truth comes back, and what cannot be known is said."""

import numpy as np
import pytest
from tests.identification.campaign_of_dahl import TRUTH, campaign
from tests.identification.synthetic import sine

from dampyr.identification import fit
from dampyr.models import Damper, Polynomial
from dampyr.records import Record


def test_one_record_gives_back_its_model_its_offset_and_its_start() -> None:
    truth = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})
    fit_result = fit(sine(truth, 0.0, w0=-0.6), "dahl")
    assert fit_result.converged, fit_result.reason
    assert list(fit_result.parameters.values()) == pytest.approx([900.0, 70.0, 2500.0], rel=1e-6)
    assert fit_result.nuisances["test"].offset == pytest.approx(120.0, abs=1e-4)
    assert fit_result.nuisances["test"].states["dahl.w"] == pytest.approx(-0.6, abs=1e-4)


@pytest.mark.prove
def test_all_six_normalised_bouc_wen_parameters_come_back() -> None:
    values = {"c0": 600.0, "k0": 900.0, "kw": 120.0, "rho": 700.0, "sigma": 1.6, "n": 1.4}
    truth = Damper("bouc_wen", {f"bouc_wen.{k}": v for k, v in values.items()})
    fit_result = fit(sine(truth, 0.0), "bouc_wen")
    assert fit_result.converged, fit_result.reason
    assert list(fit_result.parameters.values()) == pytest.approx(list(values.values()), rel=1e-4)


def test_a_joint_fit_gives_back_laws_over_the_voltage() -> None:
    truth = Damper("dahl", TRUTH)
    fit_result = fit(campaign(truth), "dahl", laws={"dahl.kx": "polynomial:2", "dahl.rho": "polynomial:1"})
    assert fit_result.converged, fit_result.reason
    assert fit_result.damper is not None
    for name, law in TRUTH.items():
        np.testing.assert_allclose(fit_result.damper.all_laws[name].coefficients, law.coefficients, rtol=1e-5)


def test_a_varying_voltage_gives_a_polynomial_law() -> None:
    truth = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": Polynomial((60.0, 150.0), 0.0, 3.0), "dahl.rho": 2500.0})
    t = np.arange(0.0, 12.0, 0.005)
    u = 1.5 + 1.5 * np.sin(1.3 * t)
    x = 0.01 * np.sin(2 * np.pi * t)
    v = np.gradient(x, t)
    record = Record(t, x, truth.force(t, x, voltage=u, velocity=v) + 30.0, velocity=v, voltage=u)
    fit_result = fit(record, "dahl", laws={"dahl.kx": "constant", "dahl.kw": "polynomial:1", "dahl.rho": "constant"})
    assert fit_result.damper is not None
    np.testing.assert_allclose(fit_result.damper.coefficients, truth.coefficients, rtol=1e-3)


def test_a_varying_voltage_gives_a_law_of_what_the_state_remembers() -> None:
    truth = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 90.0, "dahl.rho": Polynomial((500.0, 200.0), 0.0, 3.0)})
    t = np.arange(0.0, 12.0, 0.005)
    u = 1.5 + 1.5 * np.sin(9.0 * t)
    x = 0.004 * np.sin(2 * np.pi * t)
    v = np.gradient(x, t)
    record = Record(t, x, truth.force(t, x, voltage=u, velocity=v) + 30.0, velocity=v, voltage=u)
    fit_result = fit(record, "dahl", laws={"dahl.kx": "constant", "dahl.kw": "constant", "dahl.rho": "polynomial:1"})
    assert fit_result.converged
    assert fit_result.iterations < 12
    assert fit_result.damper is not None
    np.testing.assert_allclose(fit_result.damper.coefficients, truth.coefficients, rtol=1e-6)


@pytest.mark.prove
def test_the_first_try_composition_comes_back() -> None:
    laws = {"dahl.kx": 800.0, "dahl.kw": 60.0, "dahl.rho": 900.0, "spring.k0": 1500.0, "delay.tau": 0.0085}
    laws |= {"hyperbolic_tangent.c": 0.0, "hyperbolic_tangent.ft": 90.0}
    laws |= {"hyperbolic_tangent.v0": 0.008, "hyperbolic_tangent.s": 0.0}
    truth = Damper("dahl + hyperbolic_tangent + spring + delay", laws)
    records = [sine(truth, 0.0, f"r{k}", 0.004 + 0.004 * k, 0.5 + 0.4 * k) for k in range(3)]
    fixed = {"hyperbolic_tangent.c": 0.0, "hyperbolic_tangent.s": 0.0}
    fit_result = fit(records, "dahl + hyperbolic_tangent + spring + delay", fixed=fixed)
    free = {name: value for name, value in laws.items() if name not in fixed}
    assert fit_result.parameters == pytest.approx(free, rel=1e-3)
    assert fit_result.scores["r0"].l1 < 1e-4


def test_an_inverted_force_is_told() -> None:
    truth = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 2500.0})
    record = sine(truth, 0.0)
    fit_result = fit(record.replace(note="turned round", force=-record.force), "dahl")
    assert any("sign inverted" in note for note in map(str, fit_result.findings))
