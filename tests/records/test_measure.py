"""Frequency, amplitude, harmonics and energy are measured, and labels that disagree are reported."""

import numpy as np
import pytest

from dampyr import records
from dampyr.errors import InputError
from dampyr.records import Record, measure
from dampyr.records.files.campaign_folder import campaign_rows
from dampyr.records.record import Label


@pytest.mark.parametrize("fault", [{}, {"noise": 5e-5}, {"quantum": 1e-4}], ids=str)
def test_a_drifting_distorted_sine(make_sine, fault):
    record = make_sine(amplitude=0.0085, frequency=0.873, third=-0.05, drift=5e-4, duration=20.0, **fault)
    measurement = measure(record)
    exact = 0.0085 * 2 * 1.05  # the third harmonic, in antiphase, adds to both peaks
    assert measurement.frequency_hz == pytest.approx(0.873, rel=3e-4)
    assert measurement.peak_to_peak_m == pytest.approx(exact, rel=0.01)
    assert measurement.harmonics[3] == pytest.approx(0.05, abs=2e-3)
    assert max(measurement.harmonics[k] for k in (2, 4, 5, 6, 7)) < 5e-3
    assert measurement.drift_m_per_s == pytest.approx(5e-4, abs=2e-5)
    assert measurement.mean_force == pytest.approx(120.0, abs=1.0)
    assert measurement.motion_start == pytest.approx(2.0, abs=0.03)


def test_a_dashpot_dissipates_pi_c_omega_a2(make_sine):
    measurement = measure(make_sine(amplitude=0.01, frequency=0.9, viscous=3000.0, duration=30.0))
    assert measurement.energy_per_cycle == pytest.approx(np.pi * 3000.0 * 2 * np.pi * 0.9 * 0.01**2, rel=2e-3)
    assert measurement.peak_speed == pytest.approx(2 * np.pi * 0.9 * 0.01, rel=0.02)


def test_gas_force_times_drift_is_no_dissipation(make_sine):
    still, drifting = make_sine(offset=0.0), make_sine(offset=500.0, drift=6e-4)
    assert measure(drifting).energy_per_cycle == pytest.approx(measure(still).energy_per_cycle, rel=5e-3)


def test_row_10_measures_0_675_hz_and_16_3_mm(campaign_folder, published_fits):
    (row,) = [r for r in campaign_rows(campaign_folder) if (r.table, r.row) == ("4.3", 10)]
    (record,) = [r for r in published_fits if r.name + ".mat" == row.file_name]
    measurement = measure(record)
    assert measurement.frequency_hz == pytest.approx(0.675, abs=2e-3)
    assert measurement.peak_to_peak_m == pytest.approx(0.0163, abs=1e-4)


def test_the_real_motion_is_a_distorted_sine_of_29_to_76_mm_per_s(published_fits):
    measurements = [measure(record) for record in published_fits]
    assert 0.028 < min(m.peak_speed for m in measurements) < 0.030
    assert 0.072 < max(m.peak_speed for m in measurements) < 0.077
    assert min(m.harmonics[3] for m in measurements) > 0.022
    assert max(m.harmonics[3] for m in measurements) < 0.085
    assert all(m.harmonics[k] < 0.025 for m in measurements for k in (2, 4, 5, 6, 7))
    assert all(m.energy_per_cycle > 0 for m in measurements)


@pytest.mark.parametrize("phase", [0.0, 0.4, 1.3])
def test_the_frequency_of_one_whole_cycle_between_ramps_is_one_over_its_duration(phase):
    """Two cycles with a taper of one cycle at both ends hold one of full amplitude; a fit of all else beside f was 9 % off."""
    t = np.arange(0.0, 4.0, 0.001)
    envelope = np.clip(np.minimum(t, 4.0 - t), 0.0, 1.0)
    x = 0.008 * envelope * np.sin(2 * np.pi * t + phase) + 2e-6 * np.random.default_rng(3).standard_normal(t.size)
    measured = measure(Record(t, x, np.gradient(x, t)))
    assert measured.frequency_hz == pytest.approx(1.0, rel=0.02)


def test_distortion_and_error_of_the_amplitude_of_a_record() -> None:
    time = np.arange(0, 10.0, 0.001)
    phase = 2 * np.pi * 0.84 * time
    x = 0.0081 * (np.sin(phase) + 0.03 * np.sin(3 * phase + 1) + 0.04 * np.sin(5 * phase))
    record = records.Record(
        time=time, displacement=x, force=np.cos(phase), voltage=0.0, name="a", label=Label(0.016, 0.84)
    )
    assert records.total_harmonic_distortion(record) == pytest.approx(0.05, rel=1e-6)
    assert records.amplitude_error(record) == pytest.approx(0.0125, rel=1e-6)
    with pytest.raises(InputError, match="no label that says its peak to peak"):
        records.amplitude_error(records.Record(time=time, displacement=x, force=np.cos(phase), voltage=0.0, name="a"))
