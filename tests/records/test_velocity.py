"""The derivative against closed forms: exact on cubics, the stated bandwidth on sines, no phase."""

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.records import differentiate, with_velocity
from dampyr.records.conditioning.velocity import default_bandwidth, response

T = 0.005 * np.arange(1201)


def gain_and_phase(frequency, bandwidth):
    omega = 2 * np.pi * frequency
    slope = differentiate(T, np.sin(omega * T), bandwidth)
    inner = slice(200, -200)
    basis = np.column_stack([np.cos(omega * T[inner]), np.sin(omega * T[inner])])
    a, b = np.linalg.lstsq(basis, slope[inner], rcond=None)[0]
    return np.hypot(a, b) / omega, np.arctan2(b, a)


@pytest.mark.parametrize(("bandwidth", "within"), [(5.0, 1e-4), (12.0, 1e-4), (50.0, 3e-3)])
def test_half_power_at_the_stated_bandwidth_and_no_phase(bandwidth, within):
    gain, phase = gain_and_phase(bandwidth, bandwidth)
    assert gain == pytest.approx(np.sqrt(0.5), rel=within)
    assert abs(phase) < 1e-9


@pytest.mark.parametrize("frequency", [1.0, 3.0, 7.0, 15.0])
def test_the_gain_is_the_closed_form(frequency):
    gain, _ = gain_and_phase(frequency, 10.0)
    assert gain == pytest.approx(float(response(frequency, 10.0)), abs=1e-4)


def test_exact_for_cubics_to_the_very_ends():
    t = np.sort(np.random.default_rng(3).uniform(0, 6, 1201))
    t = 0.9 * T + 0.1 * t  # uneven
    for time in (T, t):
        exact = 2 - 3 * time + 1.5 * time**2
        velocity = differentiate(time, 1 + 2 * time - 1.5 * time**2 + 0.5 * time**3, 10.0)
        assert np.max(np.abs(velocity - exact)) < 1e-9 * np.max(np.abs(exact))


def test_even_and_uneven_sampling_agree():
    x = np.sin(7 * T)
    nudged = T.copy()
    nudged[0] -= 1e-4
    assert differentiate(nudged, x, 10.0)[100:-100] == pytest.approx(differentiate(T, x, 10.0)[100:-100], abs=1e-9)


@pytest.mark.parametrize("bandwidth", [0.5, 60.0, np.nan, 0.0, -3.0])
def test_a_bandwidth_that_the_sampling_cannot_carry(bandwidth):
    with pytest.raises(InputError, match=r"bandwidth_hz = .* is not allowed; .* carry from 0.6667 to 50 Hz"):
        differentiate(T, np.sin(T), bandwidth)


def test_with_velocity_states_its_bandwidth(make_sine):
    record = make_sine(quantum=5e-6)
    truth = 0.01 * 2 * np.pi * 0.9 * np.cos(2 * np.pi * 0.9 * (record.time - 2.0))
    derived = with_velocity(record)
    assert default_bandwidth(record) == pytest.approx(13.5, rel=0.01)
    assert "-3 dB at 13.5" in derived.history[-1]
    assert float(derived.provenance["velocity_bandwidth_hz"]) == pytest.approx(13.5, rel=0.01)
    inner = record.time > 2.3
    raw = np.gradient(record.displacement, record.time)
    assert np.std((derived.velocity - truth)[inner]) < 0.5 * np.std((raw - truth)[inner])
    assert np.max(np.abs(derived.velocity - truth)[inner]) < 0.01 * np.max(truth)
    assert with_velocity(record, 8.0).provenance["velocity_bandwidth_hz"] == "8"
