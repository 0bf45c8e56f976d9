"""Profiles: the interval of a parabola where the model is linear, asymmetric ones, open sides, and wrong calls."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.signal import lfilter
from tests.identification.synthetic import sine

from dampyr.errors import InputError
from dampyr.identification import Fit, fit, profile
from dampyr.identification.parameter_uncertainty import profile_likelihood as module
from dampyr.models import Damper
from dampyr.records import Record

DAMPER = Damper("dahl", {"dahl.kx": 1200.0, "dahl.kw": 200.0, "dahl.rho": 4000.0})


def noisy_records(
    damper: Damper = DAMPER,
    count: int = 8,
    amplitude: tuple[float, float] = (0.004, 0.012),
    seed: int = 0,
    seconds: float = 6.0,
) -> list[Record]:
    """Sines with correlated noise and a gain of each record."""
    rng = np.random.default_rng(seed)
    records = []
    for k in range(count):
        clean = sine(damper, 0.0, f"test {k}", rng.uniform(*amplitude), rng.uniform(0.5, 1.5), seconds=seconds)
        spread = 0.02 * float(np.std(clean.force))
        noise = lfilter([1.0], [1.0, -0.98], rng.normal(0.0, spread, clean.n + 300))[300:]
        gain = 1.0 + 0.03 * rng.standard_normal()
        records.append(clean.replace(note="with noise", force=gain * clean.force + noise))
    return records


@pytest.fixture(scope="module")
def records() -> list[Record]:
    return noisy_records()


@pytest.fixture(scope="module")
def linear(records: list[Record]) -> Fit:
    """Of a model that is linear in all that is fitted."""
    return fit(records, "dahl", fixed={"dahl.rho": 4000.0}, nuisances=("offset",))


@pytest.mark.parametrize("level", [pytest.param(0.8, marks=pytest.mark.by_hand), 0.95])
def test_where_the_model_is_linear_the_profile_gives_the_intervals_of_the_fit(linear: Fit, level: float) -> None:
    for label, interval in linear.intervals(level).items():
        one = profile(linear, label, level)
        width = interval[1] - interval[0]
        np.testing.assert_allclose(one.interval, interval, atol=2e-4 * width)
        assert one.closed == (True, True)
        np.testing.assert_allclose(
            one.rise, ((one.values - one.value) / one.standard_error) ** 2, atol=2e-3 * one.threshold
        )


def test_a_wrong_scale_is_seen(linear: Fit) -> None:
    wrong = replace(linear, stderr={label: 1.1 * error for label, error in linear.stderr.items()})
    label = "dahl.kw"
    width = linear.intervals()[label][1] - linear.intervals()[label][0]
    assert abs(profile(wrong, label).interval[0] - linear.intervals()[label][0]) > 0.03 * width


def test_where_sliding_is_hardly_reached_the_interval_is_asymmetric() -> None:
    small = fit(noisy_records(amplitude=(2e-5, 6e-5), seed=3), "dahl")
    one = profile(small, "dahl.kw")
    assert one.closed == (True, True), one.reason
    below, above = one.value - one.interval[0], one.interval[1] - one.value
    assert above > 2.0 * below  # a larger kw with a smaller rho has the same slope
    middle = int(np.argmin(one.rise))
    assert all(a >= b for a, b in pairwise(one.rise[: middle + 1]))
    assert all(a <= b for a, b in pairwise(one.rise[middle:]))
    low, high = small.intervals()["dahl.kw"]
    assert one.interval[1] > high
    assert one.interval[0] > low


def test_a_side_that_does_not_close_is_open() -> None:
    hardly = fit(noisy_records(amplitude=(1e-5, 3e-5), count=4, seed=3), "dahl")
    kw, rho = profile(hardly, "dahl.kw"), profile(hardly, "dahl.rho")
    assert kw.closed == (True, False)
    assert kw.interval[1] == math.inf
    assert kw.reason == "open above: the records do not bound it"
    assert rho.closed == (False, True)
    assert rho.interval[0] == 0.0
    assert repr(rho).startswith("<Profile 'dahl.rho'>")


def test_a_number_at_its_limit_has_one_side(records: list[Record]) -> None:
    limited = fit(records, "dahl + inertia")
    assert math.isnan(limited.stderr["inertia.m"]), limited.parameters
    one = profile(limited, "inertia.m")
    assert one.closed == (False, True)
    assert one.interval[0] == 0.0
    assert one.interval[1] > 0.0
    assert any("its rise is scaled" in finding.words for finding in one.findings)


def test_one_or_two_records_give_a_curve_and_no_interval(records: list[Record]) -> None:
    two = fit(records[:2], "dahl")
    one = profile(two, "dahl.kw")
    assert one.within
    assert all(map(math.isnan, one.interval))
    assert one.values.size > 10
    assert "no interval" in one.findings[-1].words


def test_the_fit_that_stopped_early_is_named(records: list[Record]) -> None:
    early = fit(records, "dahl", steps=1)
    assert not early.converged
    notes = [finding.words for finding in profile(early, "dahl.rho").findings]
    assert "the search did not converge" in notes[0]
    assert any("had not ended at its lowest point" in note for note in notes), notes


@pytest.mark.usefixtures("no_trials")
def test_a_number_that_is_known_to_no_power_of_ten_ends_within_its_allowed_values(records: list[Record]) -> None:
    inverted = fit([record.replace(note="turned", force=-record.force) for record in records], "dahl")
    one = profile(inverted, "dahl.rho")
    assert one.closed != (True, True)
    assert "open" in one.reason


def test_as_dict_is_plain(linear: Fit) -> None:
    data = profile(linear, "dahl.kx").as_dict()
    assert data["closed"] == [True, True]
    assert len(data["values"]) == len(data["rise"])


def test_wrong_calls_say_what_is_wrong(linear: Fit) -> None:
    with pytest.raises(InputError, match=r"'dahl\.rho' is not a number of this fit; choose from dahl\.kx"):
        profile(linear, "dahl.rho")
    with pytest.raises(InputError, match=r"level = 1\.5"):
        profile(linear, "dahl.kx", level=1.5)
    with pytest.raises(InputError, match="points = 2"):
        profile(linear, "dahl.kx", points=2)


def test_without_any_error_a_rise_has_no_scale(linear: Fit) -> None:
    none = replace(linear, stderr=dict.fromkeys(linear.stderr, math.inf))
    with pytest.raises(InputError, match="has no scale"):
        profile(none, "dahl.kx")


def test_inverse_of_numbers_with_units_of_their_own() -> None:
    matrix = np.array([[4e-12, 1e-3], [1e-3, 1e6]])
    expected = np.array([[1e6, -1e-3], [-1e-3, 4e-12]]) / 3e-6
    np.testing.assert_allclose(module.scaled_inverse(matrix), expected, rtol=1e-9)


@pytest.mark.by_hand
def test_on_the_campaign_profiles_agree_with_the_intervals_of_linear_numbers(
    published_fit_records: list[Record],
) -> None:
    records = [r for r in published_fit_records if r.voltage == 3.212]
    fitted = fit(records, "dahl")
    for label, interval in fitted.intervals().items():
        one = profile(fitted, label)
        tolerance = 0.01 if label != "dahl.rho" else 0.05
        np.testing.assert_allclose(one.interval, interval, atol=tolerance * (interval[1] - interval[0]))
