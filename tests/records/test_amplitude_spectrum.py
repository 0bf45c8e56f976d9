"""The amplitude spectrum and the table of cycles, against what the records were made of."""

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.records import Record, cut_cycles, cycle_table, cycles, describe, spectrum
from dampyr.records.cycle_analysis.amplitude_spectrum import repeated_spectrum


def two_tones(offset=0.0):
    """80 whole periods of 2 Hz and their third harmonic, at 500 samples/s, moving from the first sample on."""
    t = np.arange(20_000) / 500.0
    phase = 2 * np.pi * 2.0 * t
    x = 0.01 * np.sin(phase)
    force = offset + 300.0 * np.cos(phase) + 40.0 * np.cos(3 * phase + 0.3)
    return Record(t, x, force, velocity=0.01 * 4 * np.pi * np.cos(phase), voltage=1.0)


def test_a_sine_stands_at_its_frequency_with_its_amplitude():
    f, a = spectrum(two_tones(100.0))
    assert f[np.argmax(a)] == pytest.approx(2.0, abs=f[1])
    assert a.max() == pytest.approx(300.0, rel=2e-3)
    third = np.abs(f - 6.0) < 0.5
    assert a[third].max() == pytest.approx(40.0, rel=2e-3)
    assert a[(f > 3) & (f < 5)].max() < 0.1


def test_a_channel_that_is_not_there_is_told():
    with pytest.raises(InputError, match="has no warmth; choose from displacement, force, velocity"):
        spectrum(two_tones(), "warmth")


def test_whole_cycles_stand_for_a_test_with_a_rest_a_run_in_and_cycles_that_differ():
    """A Hann window over all of it puts 250 N at 1.9 Hz; the cycles have 300 N at 2.01 Hz, their mean."""
    t = np.arange(7_000) / 500.0
    phase = 2 * np.pi * np.cumsum(np.where(t < 5.0, 2.0, 2.02)) / 500.0
    grown = np.clip((t - 1.0) / 2.0, 0.0, 1.0) * np.clip((13.0 - t) / 2.0, 0.0, 1.0)
    force = 20.0 + grown * (300.0 * np.cos(phase) + 40.0 * np.cos(3 * phase + 0.3))
    told = repeated_spectrum(Record(t, 0.01 * grown * np.sin(phase), force, voltage=1.0))
    first, second, third = told.harmonics()[:3]
    assert told.of == f"{told.cycles} whole cycles"
    assert told.cycles > 10
    assert told.excitation == first["frequency"] == pytest.approx(2.015, abs=0.01)
    assert (first["number"], first["amplitude"]) == (1, pytest.approx(300.0, rel=0.01))
    assert second["amplitude"] < 1.0
    assert third["frequency"] == pytest.approx(3 * first["frequency"])
    assert third["amplitude"] == pytest.approx(40.0, rel=0.02)


def test_a_motion_that_does_not_repeat_itself_is_averaged_over_segments():
    t = np.arange(20_000) / 500.0
    noise = np.random.default_rng(3).normal(size=t.size)
    x = np.convolve(noise, np.hanning(200) / 100, "same") * 1e-3
    told = repeated_spectrum(Record(t, x, 30.0 * noise + 100.0 * np.sin(2 * np.pi * 40.0 * t), voltage=1.0))
    assert (told.excitation, told.harmonics()) == (None, [])
    assert told.of.startswith("segments of 13.3 s, averaged")
    at = np.argmax(told.amplitudes)
    assert told.frequencies[at] == pytest.approx(40.0, abs=0.1)
    assert told.amplitudes[at] == pytest.approx(100.0, rel=0.16)  # a Hann window between two lines
    with pytest.raises(InputError, match="has no warmth"):
        repeated_spectrum(two_tones(), "warmth")


def test_every_cycle_of_a_viscous_damper_is_as_its_formula():
    t = np.arange(5_000) / 500.0
    x, v = 0.01 * np.sin(4 * np.pi * t), 0.04 * np.pi * np.cos(4 * np.pi * t)
    table = cycle_table(Record(t, x, 120.0 + 2000.0 * v, voltage=1.0))
    assert [one.number for one in table] == list(range(1, 21))
    window = np.arccos(0.95)  # of phase, to each side of the peak velocity: the pick-up is the mean of the force there
    mean = np.sin(window) / window
    for one in table[:-1]:  # the record ends a sample before the last one does
        assert one.period_s == pytest.approx(0.5, rel=0.01)
        assert one.stroke_m == pytest.approx(0.02, rel=1e-3)
        assert one.energy == pytest.approx(np.pi * 2000.0 * 4 * np.pi * 0.01**2, rel=5e-3)
        assert one.speed_out == pytest.approx(0.04 * np.pi, rel=5e-3)
        assert one.force_out == pytest.approx(2000.0 * 0.04 * np.pi * mean, rel=5e-3)
        assert one.force_in == pytest.approx(-2000.0 * 0.04 * np.pi * mean, rel=5e-3)
        assert one.largest_force == pytest.approx(120.0 + 80.0 * np.pi, rel=1e-3)


def test_a_record_without_cycles_has_no_table():
    t = np.arange(100) / 100.0
    with pytest.raises(InputError, match="no whole cycle"):
        cycle_table(Record(t, 0.01 * t, 5.0 * t, voltage=1.0))


@pytest.mark.parametrize("seed", [1, 3, 5])
@pytest.mark.parametrize("grid", [0.0, 1e-4])
def test_a_random_motion_has_cycles_and_a_spectrum_or_says_why_not(seed, grid):
    """A random walk passes its middle from one sample to the next: such a pass is no cycle."""
    rng, t = np.random.default_rng(seed), 0.01 * np.arange(2001)
    x = 7e-5 * np.cumsum(rng.standard_normal(t.size))
    x = np.round(x / grid) * grid if grid else x
    record = Record(t, x, 100.0 * np.sin(8.0 * np.pi * t) + rng.standard_normal(t.size), voltage=0.0)
    assert all(cycle.last - cycle.first >= 3 for cycle in cut_cycles(record).cycles)
    assert np.isfinite(repeated_spectrum(record).amplitudes).all()
    assert cycles(record) is not None
    assert describe(record)["name"] == record.name
