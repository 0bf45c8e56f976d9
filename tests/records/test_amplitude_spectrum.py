"""The amplitude spectrum and the table of cycles, against what the records were made of."""

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.records import Record, cycle_table, spectrum


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
