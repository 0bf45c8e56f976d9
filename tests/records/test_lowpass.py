"""The low-pass of a displacement against its closed form, and when noise hides the direction of motion."""

import numpy as np
import pytest
from tests.stories.laboratory import earthquake, sine

from dampyr.errors import InputError
from dampyr.records import Record, displacement_noise, with_lowpass
from dampyr.records.conditioning.lowpass import multiple_or_hz
from dampyr.records.conditioning.velocity import response

T = 0.005 * np.arange(2401)


def record(x, t=T, **fields):
    return Record(t, x, np.sin(t), **fields)


@pytest.mark.parametrize("frequency", [0.5, 5.0, 10.0, 20.0])
def test_the_gain_is_the_closed_form_and_there_is_no_phase(frequency):
    omega = 2 * np.pi * frequency
    passed = with_lowpass(record(np.sin(omega * T)), 10.0).displacement[200:-200]
    basis = np.column_stack([np.cos(omega * T), np.sin(omega * T)])[200:-200]
    a, b = np.linalg.lstsq(basis, passed, rcond=None)[0]
    assert b == pytest.approx(float(response(frequency, 10.0)), abs=3e-3)
    assert abs(a) < 1e-9


def test_exact_for_cubics_to_the_very_ends_of_uneven_samples():
    for t in (T, 0.9 * T + 0.1 * np.sort(np.random.default_rng(3).uniform(0, 12, T.size))):
        cubic = 1 + 2 * t - 1.5 * t**2 + 0.05 * t**3
        np.testing.assert_allclose(with_lowpass(record(cubic, t), 10.0).displacement, cubic, atol=1e-8)


def test_a_multiple_of_the_motions_frequency_and_the_history():
    made = with_lowpass(record(0.01 * np.sin(2.4 * np.pi * T)), "15 f")
    assert made.history[-1] == "displacement after a low-pass: local cubic, no phase, -3 dB at 18 Hz"
    assert float(made.provenance["displacement_lowpass_hz"]) == pytest.approx(18.0, rel=1e-3)
    assert multiple_or_hz("20 Hz") == (20.0, False)
    assert multiple_or_hz(20) == (20.0, False)


@pytest.mark.parametrize(
    ("lowpass", "words"),
    [
        (0.0, "is not a frequency; give Hz above 0"),
        ("fast", "is not a frequency"),
        (True, "is not a frequency"),
        (80.0, "lowpass: bandwidth_hz = 80 Hz is not allowed; samples 0.005 s apart"),
    ],
)
def test_what_is_no_low_pass_is_refused(lowpass, words):
    broad = record(np.cumsum(np.random.default_rng(1).standard_normal(T.size)) * 1e-4)
    with pytest.raises(InputError, match=words):
        with_lowpass(broad, lowpass)


def test_noise_of_3_um_hides_the_direction_of_an_earthquake_and_the_proposed_low_pass_leaves_a_third():
    t, x = earthquake(1)
    noisy = record(x + 3e-6 * np.random.default_rng(0).standard_normal(t.size), t)
    noise = displacement_noise(noisy)
    assert noise.rms == pytest.approx(3e-6, rel=0.1)
    wrong = np.mean(np.diff(noisy.displacement) * np.diff(x) < 0)
    assert noise.backward == pytest.approx(wrong, rel=0.3)
    passed = with_lowpass(noisy, noise.lowpass_hz)
    assert np.std(passed.displacement - x) == pytest.approx(noise.rms_after, rel=0.3)
    assert noise.rms_after < 1.1e-6
    [note] = noise.notes
    assert note in [one.words for one in noisy.findings]
    assert f"--lowpass {noise.lowpass_hz:.3g}" in note
    assert not displacement_noise(passed).hides_direction
    assert displacement_noise(record(x, t)).notes == ()


def test_few_samples_a_cycle_are_not_taken_for_noise():
    t = 0.01 * np.arange(60)
    assert displacement_noise(record(np.sin(100 * t), t)).notes == ()


def test_neither_a_clean_sine_nor_the_campaign_is_flagged(published):
    t, x = sine(10.0, 1.0)
    assert displacement_noise(record(x, t)).backward == 0.0
    assert displacement_noise(record(5e-6 * np.round(x / 5e-6), t)).notes == ()
    assert [r.name for r in published if displacement_noise(r).notes] == []
