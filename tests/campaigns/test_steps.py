"""What is particular to one kind of step."""

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

from dampyr.campaigns.kinds import kind
from dampyr.campaigns.paths import AFTER
from dampyr.errors import InputError
from dampyr.ground_motions import el_centro
from dampyr.ground_motions.intensity_measures import pgd, pgv
from dampyr.rig import RigSettings

RIG = RigSettings()


def crossings(t, x):
    """Times at which x rises through 0."""
    k = np.flatnonzero((x[:-1] < 0) & (x[1:] >= 0))
    return t[k] - x[k] * (t[k + 1] - t[k]) / (x[k + 1] - x[k])


def test_a_sweep_changes_its_frequency_by_as_many_octaves_every_second():
    step = kind("sweep")(0.005, 0.5, 4.0, duration=30.0, rest_before=1.0, period=0.001)
    drive = step.drive(RIG)
    t = np.arange(drive.n) * drive.period
    at = crossings(t, drive.displacement)
    frequency, middle = 1 / np.diff(at), 0.5 * (at[1:] + at[:-1]) - 1.0 - 2 / 0.5
    inside = (middle > 1.0) & (middle < step.swept - 1.0)
    np.testing.assert_allclose(frequency[inside], 0.5 * 8.0 ** (middle[inside] / step.swept), rtol=4e-3)
    assert step.swept == pytest.approx(30.0, rel=0.01)


def test_a_sweep_may_run_down():
    drive = kind("sweep")(0.005, 4.0, 0.5, duration=10.0).drive(RIG)
    at = crossings(np.arange(drive.n) * drive.period, drive.displacement)
    assert np.diff(at)[2] < 0.3 < 1.5 < np.diff(at)[-2]


def test_a_random_path_has_its_band_and_nothing_else():
    step = kind("random")(0.01, low=0.5, high=2.0, duration=40.0, taper=0.001, rest_before=0.0, seed=3)
    x = step.drive(RIG).displacement[: round(40.0 / 0.01)]
    power = np.abs(np.fft.rfft(x)) ** 2
    f = np.fft.rfftfreq(x.size, 0.01)
    band = (f >= 0.5 - 1e-9) & (f <= 2.0 + 1e-9)
    assert power[band].sum() > 0.9998 * power.sum()  # what is left is the first sample, which the taper makes 0
    speed = f[band] * np.sqrt(power[band])
    assert np.ptp(speed) < 0.02 * speed.mean()


def test_random_levels_fill_their_range_and_stay_in_it():
    drive = kind("random_voltage")(0.005, 0.5, high=3.0, low=1.0, cycles=50, hold=0.2, seed=4).drive(RIG)
    levels = drive.voltage[drive.voltage > 0]
    assert 1.0 <= levels.min() < 1.05
    assert 2.95 < levels.max() <= 3.0
    assert levels.mean() == pytest.approx(2.0, abs=0.1)


def test_the_levels_of_voltage_steps_stand_over_whole_cycles_of_the_sine():
    step = kind("voltage_steps")(0.01, 0.5, voltages=(1.0, 2.0), hold=4.0, rest_before=1.0)
    drive = step.drive(RIG)
    on = np.flatnonzero(drive.voltage > 0) * drive.period
    assert on[0] == pytest.approx(3.0, abs=0.01)
    assert on[-1] - on[0] == pytest.approx(8.0, abs=0.02)
    assert drive.duration == pytest.approx(1.0 + 2.0 + 8.0 + 2.0 + AFTER, abs=0.01)


def test_the_places_of_the_gas_force_are_met_on_both_ways():
    drive = kind("gas_force")(0.01, places=5, hold=1.0).drive(RIG)
    x = np.round(drive.displacement[1:][np.diff(drive.displacement) == 0.0], 9)
    counts = {place: int(np.sum(x == place)) for place in (-0.01, -0.005, 0.005, 0.01)}
    assert counts[-0.005] == pytest.approx(200, abs=6)
    assert counts[0.005] == pytest.approx(200, abs=6)
    assert counts[0.01] == pytest.approx(100, abs=4)
    assert counts[-0.01] == pytest.approx(200, abs=6)  # first and last


def test_low_speeds_come_in_their_order():
    drive = kind("low_velocity")(0.002, speeds=(0.001, 0.004), rest_before=0.0).drive(RIG)
    speeds = np.abs(np.diff(drive.displacement)) / drive.period
    assert speeds[: drive.n // 2].max() == pytest.approx(0.001)
    assert speeds.max() == pytest.approx(0.004)


def test_a_warm_up_ends_at_its_temperature_and_other_steps_do_not():
    assert kind("warm_up")(0.005, 1.0, temperature=35.0).drive(RIG).until_temperature == 35.0
    assert kind("warm_up")(0.005, 1.0).drive(RIG).until_temperature is None


def test_an_earthquake_is_the_record_filtered_and_integrated():
    step = kind("earthquake")(scale=0.1, rest_before=1.0)
    drive = step.drive(RIG)
    x = drive.displacement[100:]
    v = cumulative_trapezoid(np.gradient(np.gradient(x, 0.01), 0.01), dx=0.01)
    peaks = step.peaks(RIG)
    assert np.abs(v).max() == pytest.approx(peaks.speed, rel=0.02)
    assert np.abs(x).max() == pytest.approx(peaks.position, rel=1e-3)
    a = np.gradient(np.gradient(x, 0.01), 0.01)[: 2 * el_centro().n : 2][:1500] / 0.1
    assert np.corrcoef(a, el_centro().acceleration[:1500])[0, 1] > 0.98
    assert peaks.position < 0.1 * pgd(el_centro())
    assert peaks.speed == pytest.approx(0.1 * pgv(el_centro()), rel=0.15)


@pytest.mark.parametrize(
    ("name", "settings", "words"),
    [
        ("sine", {"amplitude": 0.01, "frequency": 1.0, "cycles": 0}, "cycles = 0"),
        ("sine", {"amplitude": -0.01, "frequency": 1.0}, "amplitude = -0.01 m"),
        ("sine", {"amplitude": 0.01, "frequency": 15.0}, "at most 8.33 ms"),
        ("sweep", {"amplitude": 0.01, "start": 1.0, "stop": 1.0}, "use the kind sine"),
        ("sweep", {"amplitude": 0.01, "start": 0.1, "stop": 0.2, "duration": 5.0}, "less than 2 cycles"),
        ("random", {"amplitude": 0.01, "low": 1.0, "high": 1.01}, "fewer than two frequencies"),
        ("random", {"amplitude": 0.01, "duration": 3.0}, "taper = 2 s"),
        ("random_voltage", {"amplitude": 0.01, "frequency": 1.0, "high": 1.0, "low": 2.0}, "exchange them"),
        ("voltage_steps", {"amplitude": 0.01, "frequency": 1.0, "voltages": ()}, "voltages is empty"),
        ("low_velocity", {"speeds": ()}, "speeds is empty"),
        ("gas_force", {"amplitude": 0.01, "places": 1}, "places = 1"),
        ("reversals", {"half_period": 0.3, "duty": 1.5}, "duty = 1.5"),
    ],
)
def test_what_makes_no_sense_is_refused(name, settings, words):
    with pytest.raises(InputError, match=words):
        kind(name)(**settings)
