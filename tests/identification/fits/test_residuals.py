"""What is left: residuals of known character are recognised for what they are."""

from dataclasses import replace

import numpy as np
import pytest
from tests.identification.residual_traces import DT, NOISE, RNG, F, N, T, V, ar1, trace
from tests.identification.synthetic import sine

from dampyr.errors import InputError
from dampyr.identification import analyse, fit
from dampyr.identification.fits.diagnostics import findings, residual_findings
from dampyr.identification.fits.residuals import (
    SIDES,
    autocorrelation,
    correlation_intervals,
    motion,
    noise_of,
)
from dampyr.models import Damper


def test_white_noise_is_noise_and_nothing_else() -> None:
    analysis = analyse([trace(NOISE)])
    (one,) = analysis.records
    assert one.rms == pytest.approx(2.0, rel=0.03)
    assert one.noise == pytest.approx(one.rms, rel=0.03)
    assert one.correlation_time == pytest.approx(DT, rel=0.15)
    assert analysis.effective == pytest.approx(N, rel=0.15)
    assert abs(one.repeats) < 0.05
    assert not one.misfit
    assert residual_findings(analysis) == []
    text = " ".join(findings(analysis))
    assert "nearly independent" in text
    assert "alike in both directions" in text
    assert "little of it repeats" in text


@pytest.mark.parametrize("phi", [0.5, 0.9, 0.97])
def test_the_memory_of_an_autoregression_is_its_closed_form(phi: float) -> None:
    r = ar1(phi, 3.0, 200_000)
    intervals = correlation_intervals(autocorrelation(r))
    assert intervals == pytest.approx((1 + phi) / (1 - phi), rel=0.1)
    assert noise_of(r) == pytest.approx(3.0 * np.sqrt(1 - phi), rel=0.02)
    np.testing.assert_allclose(autocorrelation(r)[:6], phi ** np.arange(6), atol=0.02)


def test_effective_samples_tell_the_mean_as_well_as_they_claim() -> None:
    """The spread of the mean over many series is sigma / sqrt(effective samples)."""
    means = [float(np.mean(ar1(0.9, 1.0, 2000, seed))) for seed in range(400)]
    effective = np.mean([2000 / correlation_intervals(autocorrelation(ar1(0.9, 1.0, 2000, s))) for s in range(40)])
    assert np.std(means) == pytest.approx(1.0 / np.sqrt(effective), rel=0.15)


def test_the_autocorrelation_is_the_plain_sum() -> None:
    r = RNG.normal(1.0, 2.0, 65)
    d = r - r.mean()
    np.testing.assert_allclose(autocorrelation(r), [d[: 65 - k] @ d[k:] / (d @ d) for k in range(65)], atol=1e-12)
    np.testing.assert_array_equal(autocorrelation(np.full(9, 4.0)), np.eye(9)[0])


def test_what_comes_again_in_each_cycle_is_told_from_noise() -> None:
    shape = 3.0 * np.sin(6 * np.pi * F * T + 0.4)
    (one,) = analyse([trace(shape + NOISE)]).records
    assert one.repeats == pytest.approx(4.5 / (4.5 + 4.0), abs=0.03)
    (pure,) = analyse([trace(shape)]).records
    assert pure.repeats == pytest.approx(1.0, abs=0.01)
    assert pure.misfit
    (short,) = analyse([trace(shape, frequency=2.0 / T[-1])]).records
    assert np.isnan(short.repeats)


def test_the_criterion_of_misfit_is_the_one_that_is_stated() -> None:
    """An autoregression has tau = (1 + phi)/(1 - phi) intervals and rms over noise 1/sqrt(1 - phi)."""
    (mild,) = analyse([trace(ar1(0.5, 1.0))]).records
    (long,) = analyse([trace(ar1(0.8, 1.0))]).records
    (large,) = analyse([trace(20.0 * np.sin(2 * np.pi * 40.0 * T))]).records
    assert (mild.misfit, long.misfit, large.misfit) == (False, True, False)


def test_sides_have_the_means_that_were_put_in() -> None:
    analysis = analyse([trace(np.where(V > 0, 5.0, -3.0))])
    sides = analysis.groups[0].sides
    assert (sides["out"].mean, sides["in"].mean) == (5.0, -3.0)
    assert (sides["out"].rms, sides["in"].rms) == (5.0, 3.0)
    assert sides["out"].samples + sides["in"].samples == pytest.approx(N * (1 - 2 * np.arcsin(0.02) / np.pi), abs=60)
    assert any(
        "mean differs between the directions: 5 N when the damper is pulled, −3 N when pushed" in w
        for w in map(str, residual_findings(analysis))
    )
    assert any("larger when the damper is pulled: 5 N against 3 N rms" in text for text in findings(analysis))


def test_each_quarter_of_the_cycle_has_its_own_side_in_spite_of_drift() -> None:
    phase = (F * T) % 1.0  # 0: the middle on the way out, 0.25 the upper turning point
    quarter = np.select([phase < 0.25, phase < 0.5, phase < 0.75], [1.0, 2.0, 3.0], 4.0)
    sides = analyse([trace(quarter)]).whole.sides
    means = {name: side.mean for name, side in sides.items() if "," in name}
    expected = dict(zip(SIDES[2:], (4.0, 1.0, 2.0, 3.0), strict=True))
    assert means == pytest.approx(expected, abs=0.08)


def test_curves_hold_the_quartiles() -> None:
    curve = analyse([trace(100.0 * V + NOISE)]).whole.curves["before the middle"]
    finite = np.isfinite(curve.median)
    assert finite.sum() >= 20
    np.testing.assert_allclose(curve.median[finite], 100.0 * curve.velocity[finite], atol=1.2)
    spread = np.median((curve.upper - curve.lower)[finite])
    assert spread == pytest.approx(2 * 0.6745 * 2.0, rel=0.15)


def test_groups_are_the_inputs_and_the_whole_is_all() -> None:
    analysis = analyse([trace(NOISE, "b", 2.0), trace(2 * NOISE, "a", 0.0), trace(3 * NOISE, "c", 2.0)], "A")
    assert [(g.input_value, g.records) for g in analysis.groups] == [(0.0, ("a",)), (2.0, ("b", "c"))]
    assert analysis.whole.records == ("b", "a", "c")
    assert analysis.samples == 3 * N
    assert analysis.correlation_time == pytest.approx(analysis.samples * DT / analysis.effective)
    assert analysis.noise == pytest.approx(noise_of(NOISE) * np.sqrt(14 / 3))


@pytest.mark.parametrize(
    ("traces", "words"),
    [
        (lambda: [], "no residuals to analyse"),
        (lambda: [trace(NOISE), trace(NOISE)], "the same name"),
        (lambda: [trace(np.where(T > 1.0, np.nan, 0.0))], "not finite"),
        (lambda: [replace(trace(NOISE), residual=NOISE[:-1])], "vectors of one length"),
    ],
)
def test_what_cannot_be_analysed_is_refused(traces: object, words: str) -> None:
    with pytest.raises(InputError, match=words):
        analyse(traces())


DAHL = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 120.0, "dahl.rho": 2000.0})
MIXED = Damper(
    "dahl + hyperbolic_tangent",
    {
        "dahl.kx": 300.0, "dahl.kw": 60.0, "dahl.rho": 400.0, "hyperbolic_tangent.ft": 120.0, "hyperbolic_tangent.v0": 0.01,
        "hyperbolic_tangent.c": 0.0, "hyperbolic_tangent.s": 0.0,
    },
)  # fmt: skip


def test_a_fit_of_the_true_model_leaves_noise_and_one_of_another_does_not() -> None:
    true = [sine(DAHL, 0.0, f"t{k}", 0.006 + 0.002 * k, 1.2 - 0.1 * k, noise=2.0, seed=k) for k in range(4)]
    right = fit(true, "dahl").residuals
    assert right.misfits == ()
    assert right.whole.rms == pytest.approx(2.0, rel=0.05)
    other = [sine(MIXED, 0.0, f"m{k}", 0.006 + 0.002 * k, 1.2 - 0.1 * k, noise=1.0, seed=k) for k in range(4)]
    wrong = fit(other, "dahl").residuals
    assert wrong.misfits == ("m0", "m1", "m2", "m3")
    assert any("misses more than noise in 4 of 4 records" in text for text in map(str, residual_findings(wrong)))


def test_the_motion_is_that_of_whole_cycles() -> None:
    stroke, frequency = motion(sine(DAHL, 0.0, amplitude=0.006, frequency=1.25))
    assert stroke == pytest.approx(0.012, rel=0.01)
    assert frequency == pytest.approx(1.25, rel=0.01)


def test_the_residual_of_a_fit_is_measured_less_modelled() -> None:
    """A force that is too large at speed, both ways, leaves a residual that is positive there and negative at rest."""
    records = [sine(DAHL, 0.0, f"t{k}", 0.006 + 0.002 * k, 1.2 - 0.1 * k, noise=1.0, seed=k) for k in range(3)]
    harder = [replace(r, force=r.force + 900.0 * np.abs(r.velocity)) for r in records]
    residuals = fit(harder, "dahl").residuals
    for curve in residuals.whole.curves.values():
        finite = np.isfinite(curve.median)
        fast = finite & (np.abs(curve.velocity) > 0.8 * np.abs(curve.velocity[finite]).max())
        slow = finite & (np.abs(curve.velocity) < 0.3 * np.abs(curve.velocity[finite]).max())
        assert curve.median[fast].min() > 5.0 > -5.0 > curve.median[slow].max()
    assert any("does not change its sign" in text for text in map(str, residual_findings(residuals)))
