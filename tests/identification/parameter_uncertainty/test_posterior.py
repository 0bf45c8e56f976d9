"""Samples of the posterior: against closed forms and profiles, inside the limits, seeded; a missing extra and wrong calls."""

import math
import sys
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import kstest, t
from tests.identification.parameter_uncertainty.test_profile_likelihood import noisy_records

import dampyr as dp
from dampyr.errors import InputError
from dampyr.identification import Fit, fit, profile, sample_posterior
from dampyr.identification.parameter_uncertainty import posterior
from dampyr.identification.parameter_uncertainty.posterior import Posterior, split_r_hat

pytest.importorskip("emcee", reason="the extra bayes is not installed: pip install dampyr[bayes]")


@pytest.fixture(scope="module")
def linear() -> Fit:
    """Of a model that is linear in all that is fitted: its posterior is known."""
    return fit(noisy_records(count=5, seconds=3.0), "dahl", fixed={"dahl.rho": 4000.0}, nuisances=("offset",))


#: of the chains, with what mean and covariance may differ by: four standard errors of about 250 and 600 independent draws
LENGTHS = [(16.0, 0.25), pytest.param((40.0, 0.15), marks=pytest.mark.prove)]


@pytest.fixture(scope="module", params=LENGTHS, ids=["16", "40"])
def normal(linear: Fit, request: pytest.FixtureRequest) -> tuple[Posterior, float]:
    lengths, within = request.param
    return sample_posterior(linear, tails="normal", lengths=lengths), within


@pytest.fixture
def brief(monkeypatch: pytest.MonkeyPatch) -> int:
    """So few steps that nothing has converged, for what does not depend on it."""
    monkeypatch.setattr(posterior, "CHUNK", 20)
    return 20


def covariance_of(fitted: Fit) -> np.ndarray:
    errors = np.array(list(fitted.stderr.values()))
    return fitted.correlation * np.outer(errors, errors)


def differs_from_normal(samples: Posterior, fitted: Fit) -> float:
    """The largest difference of mean and covariance from those of the fit, in standard errors."""
    table = np.stack(list(samples.samples.values()), axis=-1)
    expected, errors = covariance_of(fitted), np.array(list(fitted.stderr.values()))
    means = np.abs(table.mean(axis=0) - list(fitted.parameters.values())) / errors
    spreads = np.abs(np.cov(table, rowvar=False) - expected) / np.outer(errors, errors)
    return float(max(means.max(), spreads.max()))


def test_of_a_linear_model_it_is_normal_with_the_covariance_of_the_fit(
    linear: Fit, normal: tuple[Posterior, float]
) -> None:
    samples, within = normal
    if within < 0.2:  # shorter chains have the distribution too, and R-hat does not yet see it
        assert samples.converged, samples.reason
    assert differs_from_normal(samples, linear) < within
    for label, values in samples.samples.items():
        every = values[::4]  # nearly independent draws
        assert kstest((every - linear.parameters[label]) / linear.stderr[label], "norm").pvalue > 1e-3


def test_a_covariance_that_is_wrong_is_seen(linear: Fit, normal: tuple[Posterior, float]) -> None:
    wrong = replace(linear, stderr={label: 1.3 * error for label, error in linear.stderr.items()})
    assert differs_from_normal(normal[0], wrong) > 0.3


@pytest.mark.parametrize("tails", ["t", "normal"])
def test_its_density_is_that_of_the_tails_in_closed_form(linear: Fit, tails: str) -> None:
    """Of a linear model: q = d' C^-1 d, the density of Student's t in p dimensions, or the normal one, less that at the top."""
    [block] = linear.optimum.blocks
    target = posterior._Target(linear, block, tails, [])
    precision, freedom = np.linalg.inv(covariance_of(linear)), min(linear.freedom.values())
    errors = np.array(list(linear.stderr.values()))
    for d in np.random.default_rng(0).uniform(-3.0, 3.0, (5, errors.size)) * errors:
        q = d @ precision @ d
        expected = -0.5 * q if tails == "normal" else -0.5 * (freedom + d.size) * np.log1p(q / freedom)
        assert target.log_density(target.best + d) - target.log_density(target.best) == pytest.approx(
            expected, rel=0.01
        )


@pytest.mark.prove
def test_its_tails_are_those_of_student(linear: Fit) -> None:
    samples = sample_posterior(linear, lengths=30.0, seed=1)
    freedom = min(linear.freedom.values())
    for label, (low, high) in samples.intervals(0.8).items():
        reach = float(t.ppf(0.9, freedom)) * linear.stderr[label]
        assert 0.5 * (high - low) == pytest.approx(reach, rel=0.15)


def test_the_same_seed_gives_the_same_samples(linear: Fit, brief: int) -> None:
    one, same, other = (sample_posterior(linear, lengths=2.0, steps=brief, seed=seed) for seed in (3, 3, 4))
    assert all(np.array_equal(one.samples[label], same.samples[label]) for label in one.samples)
    assert not np.array_equal(one.samples["dahl.kx"], other.samples["dahl.kx"])


def test_chains_that_are_too_short_are_a_value_with_a_reason(linear: Fit, brief: int) -> None:
    short = sample_posterior(linear, lengths=500.0, steps=brief)
    assert not short.converged
    assert "autocorrelation times long, not 500; give more steps than 20" in short.reason
    assert "not converged" in repr(short)


@pytest.mark.usefixtures("brief")
def test_progress_ends_at_one(linear: Fit) -> None:
    shares: list[float] = []
    sample_posterior(linear, lengths=2.0, progress=lambda stage, done: shares.append(done))
    assert shares[-1] == 1.0
    assert all(0.0 <= share <= 1.0 for share in shares)


@pytest.mark.prove
def test_its_dampers_go_into_an_ensemble(linear: Fit, brief: int) -> None:
    dampers = sample_posterior(linear, lengths=2.0, steps=brief).dampers(3, seed=1)
    peaks = dp.structures.ensemble(
        dp.structures.two_storey(), [dp.ground_motions.el_centro().scaled(0.1)], dampers, voltage=[0.0], scales=[1.0]
    ).dataset
    assert peaks.sizes["damper"] == 3


@pytest.mark.prove
def test_many_steps_are_admissible_too() -> None:
    vague = fit(noisy_records(count=4, amplitude=(2e-5, 6e-5), seed=3, seconds=3.0), "dahl")
    samples = sample_posterior(vague, lengths=2.0, steps=100)
    assert all(np.all(values > 0.0) for values in samples.samples.values())


def test_its_dampers_are_admissible_and_its_samples_make_tables(brief: int) -> None:
    vague = fit(noisy_records(count=4, amplitude=(2e-5, 6e-5), seed=3, seconds=3.0), "dahl")
    samples = sample_posterior(vague, lengths=2.0, steps=brief)
    assert all(np.all(values > 0.0) for values in samples.samples.values())
    dampers = samples.dampers(3, seed=1)
    assert len({damper.values(0.0).tobytes() for damper in dampers}) > 1
    assert [damper.values(0.0)[0] for damper in dampers] == [
        damper.values(0.0)[0] for damper in samples.dampers(3, seed=1)
    ]
    assert samples.to_xarray().dims == ("sample", "parameter")
    assert list(samples.to_dataframe().columns) == list(samples.samples)
    assert samples.as_dict()["draws"] == samples.size


def test_few_records_leave_a_direction_and_a_note(brief: int) -> None:
    three = fit(noisy_records(count=3, seconds=3.0), "dahl")
    samples = sample_posterior(three, lengths=2.0, steps=brief)
    assert any(
        "3 records show no variance between them in 1 of 3 directions" in note for note in map(str, samples.findings)
    )
    assert all(np.all(np.isfinite(values)) for values in samples.samples.values())


def test_a_number_at_its_limit_is_held(brief: int) -> None:
    limited = fit(noisy_records(count=4, seconds=3.0), "dahl + inertia")
    samples = sample_posterior(limited, lengths=2.0, steps=brief)
    assert samples.held == {"inertia.m": 0.0}
    assert "inertia.m" not in samples.samples
    assert len(samples.dampers(2)) == 2


def test_what_the_records_do_not_determine_is_refused(linear: Fit) -> None:
    unknown = replace(linear, stderr=linear.stderr | {"dahl.kw": math.inf})
    with pytest.raises(InputError, match=r"do not determine dahl\.kw.*fix it"):
        sample_posterior(unknown)


def test_a_missing_extra_says_how_to_install_it(linear: Fit, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "emcee", None)
    with pytest.raises(InputError, match=r'pip install "dampyr\[bayes\]"'):
        sample_posterior(linear)


def test_wrong_calls_say_what_is_wrong(linear: Fit, brief: int) -> None:
    samples = sample_posterior(linear, lengths=2.0, steps=brief)
    for wrong, words in (
        ({"tails": "cauchy"}, "'cauchy'"),
        ({"lengths": 0.0}, "lengths = 0"),
        ({"steps": 3}, "steps = 3"),
    ):
        with pytest.raises(InputError, match=words):
            sample_posterior(linear, **wrong)
    with pytest.raises(InputError, match="n = 0"):
        samples.dampers(0)
    with pytest.raises(InputError, match="level = 2"):
        samples.intervals(2.0)


def test_a_corner_plot_draws_the_numbers_that_it_is_asked_for(linear: Fit, brief: int) -> None:
    from matplotlib import pyplot

    samples = sample_posterior(linear, seed=brief)
    first, *_, last = samples.samples
    panels = samples.plot.corner([last, first])
    pyplot.close(panels[0].figure)
    assert len(panels) == 4
    assert first.split(".")[0] in panels[3].get_xlabel()
    with pytest.raises(InputError, match=r"'dahl\.ky' is no number of the posterior; give at most 8 of"):
        samples.plot.corner(["dahl.ky"])
    with pytest.raises(InputError, match="9 labels are too many"):
        samples.plot.corner([first] * 9)


def test_r_hat_sees_walkers_that_stay_apart() -> None:
    rng = np.random.default_rng(0)
    mixed = rng.standard_normal((400, 8, 1))
    assert float(split_r_hat(mixed)[0]) == pytest.approx(1.0, abs=0.02)
    assert float(split_r_hat(mixed + np.arange(8)[:, None])[0]) > 2.0


@pytest.mark.prove
def test_of_a_model_that_is_not_linear_its_intervals_agree_with_profiles() -> None:
    records = noisy_records(count=6, amplitude=(2e-4, 6e-4), seed=3, seconds=3.0)
    small = fit(records, "dahl", fixed={"dahl.kx": 1200.0})
    samples = sample_posterior(small, lengths=60.0, steps=20_000)
    assert samples.converged, samples.reason
    for label, span in samples.intervals().items():
        one, parabola = profile(small, label), small.intervals()[label]
        width = one.interval[1] - one.interval[0]
        print(label, "profile", one.interval, "posterior", span, "standard error", parabola)
        for k in (0, 1):
            assert abs(span[k] - one.interval[k]) < 0.16 * width
    # kw has a long upper side in both, as a larger kw with a smaller rho has the same slope.
    assert samples.intervals()["dahl.kw"][1] > small.intervals()["dahl.kw"][1] < profile(small, "dahl.kw").interval[1]
