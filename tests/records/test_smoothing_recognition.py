"""Moving averages are recognised in measured and simulated records, and none in those that had none."""

import numpy as np
import pytest
from tests.stories.laboratory import MOTIONS, earthquake, sine

from dampyr.records import Record, measure, recognise_smoothing
from dampyr.records.conditioning.moving_average import Declaration, averaged, reach_of
from dampyr.records.conditioning.smoothing_recognition import Recognised, common_windows

CHANNELS = ("displacement", "velocity", "force")


def smoothed(record, samples):
    reach = reach_of(samples, False)
    there = [c for c in CHANNELS if getattr(record, c) is not None]
    return record.replace(note="smoothed", **{c: averaged(getattr(record, c), *reach) for c in there})


@pytest.mark.prove
def test_no_false_alarm_on_the_campaign(published):
    assert len(published) >= 39
    alarms = {record.name: recognise_smoothing(record) for record in published}
    assert sum(map(len, alarms.values())) == 0, alarms
    assert not any(
        "moving average" in note for record in published[::4] for note in [one.words for one in record.findings]
    )


def test_a_motion_that_nearly_repeats_itself_is_not_taken_for_smoothed():
    """Friction under a building in an earthquake has odd harmonics, as a square wave: its even ones are zeros of its own."""
    rng, t = np.random.default_rng(0), np.arange(20_000) / 1000.0
    lines = zip(2.17 + 0.25 * rng.standard_normal(9), rng.random(9), 6.28 * rng.random(9))  # Hz, amplitudes, phases
    x = 2e-3 * sum(a * np.sin(2 * np.pi * f * t + phase) for f, a, phase in lines)
    force = 100.0 * np.tanh(np.gradient(x, t) / 2e-3) + 0.2 * rng.standard_normal(t.size)
    assert recognise_smoothing(Record(t, x, force, voltage=0.0)) == ()


def test_a_tenth_of_the_period_on_the_campaign_to_the_sample(published):
    """Real noise and steps of 5 um and 0.19 N at 100 Hz, smoothed by a program with full precision."""
    for record in published[::3]:
        samples = round(0.1 / measure(record).frequency_hz / record.dt)
        shown = recognise_smoothing(smoothed(record, samples))
        assert {one.channel for one in shown} >= {"displacement", "force"}, record.name
        assert {one.samples for one in shown} == {samples}, record.name
        assert all(one.contrast > 8.0 and one.periods == pytest.approx(0.1, rel=0.1) for one in shown)


def motions():
    made = [(f"{frequency:g} Hz", *sine(amplitude, frequency), 0.1 / frequency) for amplitude, frequency in MOTIONS]
    return [*made, ("earthquake", *earthquake(1), 0.3)]


MADE = {name: (t, x, window) for name, t, x, window in motions()}


def forces(t, x):
    """Analytic ones: a dashpot, friction about zero velocity, a square wave, one with ramps."""
    v = np.gradient(x, t)
    return {
        "dashpot": 300.0 * v,
        "friction": 45.0 + 300.0 * v + 400.0 * np.tanh(v / 0.012),
        "square": 100.0 * np.sign(v),
        "ramps": 100.0 * np.clip(v / (0.3 * np.abs(v).max()), -1.0, 1.0),
    }


@pytest.mark.parametrize(
    "name", [name if name in ("1 Hz", "5 Hz") else pytest.param(name, marks=pytest.mark.prove) for name in MADE]
)
def test_no_false_alarm_on_analytic_motions_clean_rounded_or_noisy(name):
    t, x, _ = MADE[name]
    rng = np.random.default_rng(5)
    alarms = 0
    for force in forces(t, x).values():
        clean = Record(t, x, force)
        rounded = Record(t, np.round(x, 7), np.round(force, 1))
        noisy = Record(t, x + 3e-6 * rng.standard_normal(t.size), force + 3.0 * rng.standard_normal(t.size))
        barely = Record(t, x + 3e-8 * rng.standard_normal(t.size), force + 0.01 * rng.standard_normal(t.size))
        alarms += sum(len(recognise_smoothing(record)) for record in (clean, rounded, noisy, barely))
    assert alarms == 0


@pytest.mark.parametrize("decimals", [(9, 4), (7, 1)], ids=["1 nm", "0.1 um"])
@pytest.mark.parametrize(
    "name", ["1 Hz", *(pytest.param(f"{hz} Hz", marks=pytest.mark.prove) for hz in (2, 3.5, 5)), "earthquake"]
)
def test_the_window_of_noisy_motions_within_a_sample(name, decimals):
    t, x, window = MADE[name]
    rng = np.random.default_rng(6)
    record = Record(
        t, x + 3e-6 * rng.standard_normal(t.size), forces(t, x)["friction"] + 3.0 * rng.standard_normal(t.size)
    )
    samples = round(window / record.dt)
    record = smoothed(record, samples)
    record = record.replace(
        note="", displacement=np.round(record.displacement, decimals[0]), force=np.round(record.force, decimals[1])
    )
    shown = {one.channel: one for one in recognise_smoothing(record)}
    assert set(shown) == {"displacement", "force"}
    assert all(abs(one.samples - samples) <= 0.02 * samples for one in shown.values())
    assert all(one.sigmas > 6.0 for one in shown.values())
    notes = [note for note in [one.words for one in record.findings] if "moving average" in note]
    assert len(notes) == 1
    assert notes[0].startswith("displacement and force smoothed? a moving average over")
    assert "standard errors: declare it, --smoothed" in notes[0]


def test_the_differences_lie_on_the_grid_of_the_converter():
    """Without noise there is nothing to see zeros in, but counts of 5 um are counted over 50 samples."""
    t, x, _ = MADE["1 Hz"]
    counts = 5e-6 * np.round(x / 5e-6)
    record = Record(t, averaged(counts, 25, 24), np.sin(t))
    [one] = recognise_smoothing(record, steps={"displacement": 5e-6})
    assert (one.channel, one.samples, one.on_grid) == ("displacement", 50, 5e-6)
    assert recognise_smoothing(Record(t, counts, np.sin(t)), steps={"displacement": 5e-6}) == ()


def test_uneven_sampling_and_what_is_declared_are_left_alone():
    t, x, window = MADE["5 Hz"]
    rng = np.random.default_rng(8)
    record = smoothed(
        Record(t, x + 3e-6 * rng.standard_normal(t.size), rng.standard_normal(t.size)), round(window / 0.002)
    )
    assert recognise_smoothing(record)
    assert recognise_smoothing(record.replace(note="", time=t**1.05)) == ()


def shown_window(samples, dt, hz):
    return Recognised("force", samples, samples * dt, samples * dt * hz, 12.0, 9.0)


@pytest.mark.parametrize(
    ("recognised", "windows"),
    [
        # 0.1 s at three rates, of a motion of 1.016 Hz: 0.1 periods would be 98, 197 and 79 samples
        ([(100, 1e-3, 1.016), (200, 5e-4, 1.016), (80, 1.25e-3, 1.016)], {"0.1 s": 3}),
        # a tenth of the period of each of three sines, and 0.3 s of an earthquake
        ([(100, 1e-3, 1.0), (50, 1e-3, 2.0), (29, 1e-3, 3.5), (300, 1e-3, None)], {"0.1 periods": 3, "0.3 s": 1}),
        # 15 samples, whatever the rate
        ([(15, 1e-3, 1.0), (15, 5e-3, 2.0), (15, 2e-3, 3.0)], {"15 samples": 3}),
        # one record alone, and one whose window has digits
        ([(25, 4e-3, 1.0)], {"0.1 s": 1}),
        ([(496, 1e-3, None)], {"0.496 s": 1}),
    ],
)
def test_a_common_window_is_told_in_s_before_samples_before_periods(recognised, windows):
    named = {
        f"r{k}": shown_window(n, dt, hz) if hz else Recognised("force", n, n * dt, None, 12.0, 9.0)
        for k, (n, dt, hz) in enumerate(recognised)
    }
    common = common_windows(named)
    assert {window: len(names) for window, names in common.items()} == windows or (
        len(recognised) == 1 and {len(names) for names in common.values()} == {1}
    )
    for window, names in common.items():  # what is told is read as a declaration, and undoes them
        declared = Declaration.of(window)
        for name in names:
            one = named[name]
            if declared.seconds is not None:
                assert round(declared.seconds * one.samples / one.window) == pytest.approx(one.samples, abs=1)
