"""Gaps, jitter, saturation and quantisation are reported, not repaired; the start of the motion among steps and noise."""

import numpy as np
import pytest

from dampyr.records import Record, cycle_bounds, quality
from dampyr.records.checks.quality import motion_start


def test_a_clean_record_has_no_notes(make_sine):
    quality_report = quality(make_sine())
    assert quality_report.notes == ()
    assert quality_report.quantum == {"displacement": pytest.approx(5e-6)}
    assert quality_report.per_cycle == pytest.approx(111.1, abs=0.5)
    assert quality_report.jitter < 1e-9


def test_a_gap_is_found_with_its_place(make_sine):
    record = make_sine()
    selected = np.r_[0:600, 640 : record.n]
    cut = Record(record.time[selected], record.displacement[selected], record.force[selected])
    quality_report = quality(cut)
    assert quality_report.gaps == ((pytest.approx(5.99), pytest.approx(0.41)),)
    assert quality_report.notes[0] == "gap of 0.41 s at 5.99 s"


def test_jitter_is_measured(make_sine):
    record = make_sine()
    moved = record.time + 5e-4 * np.random.default_rng(2).standard_normal(record.n)
    quality_report = quality(record.replace(note="jitter", time=moved))
    assert quality_report.jitter == pytest.approx(np.sqrt(2) * 0.05, rel=0.1)
    assert "jitter" in quality_report.notes[0]


def test_a_saturated_force_is_reported(make_sine):
    record = make_sine()
    clipped = record.replace(note="clipped", force=np.minimum(record.force, 250.0))
    quality_report = quality(clipped)
    assert quality_report.saturated["force"] == int(
        np.sum(clipped.force[slice(cycle_bounds(record)[0][0], cycle_bounds(record)[-1][1])] == 250.0)
    )
    assert any("force may be saturated" in note for note in quality_report.notes)
    assert "force" not in quality(record).saturated


def test_the_real_quanta(published):
    for record in published:
        quality_report = quality(record)
        assert quality_report.quantum["displacement"] == pytest.approx(5e-6, rel=1e-6), record.name
        assert quality_report.quantum["force"] == pytest.approx(0.1873, rel=1e-3), record.name
        assert quality_report.quantum["velocity"] == pytest.approx(5e-4, rel=1e-3), record.name
        assert quality_report.notes == (), record.name


@pytest.mark.parametrize(
    "fault", [{}, {"noise": 2e-5}, {"drift": 5e-4}, {"quantum": 0.0}, {"amplitude": 2.5e-3}], ids=str
)
@pytest.mark.parametrize("rest", [0.0, 0.37, 2.0, 4.0])
def test_the_start_is_found_to_two_samples(make_sine, rest, fault):
    assert motion_start(make_sine(rest=rest, **fault)) == pytest.approx(rest, abs=0.0201)


def test_false_samples_are_told_with_their_time(make_sine):
    record = make_sine()
    force = np.array(record.force)
    force[[500, 700]] += 0.5 * np.ptp(force)
    report = quality(record.replace(note="spikes", force=force))
    assert report.spikes == {"force": (pytest.approx(record.time[500]), pytest.approx(record.time[700]))}
    assert any(note.startswith("force has 2 false samples, it seems: at") for note in report.notes)


def test_one_false_sample_in_each_real_record_is_seen(published):
    """And none where there is none: `test_the_real_records_are_clean` sees no note."""
    for record in published:
        force = np.array(record.force)
        force[record.n // 2] += 2.0 * np.ptp(force)
        times = quality(record.replace(note="spike", force=force)).spikes["force"]
        assert times == (pytest.approx(record.time[record.n // 2]),), record.name


def test_one_encoder_step_during_the_rest_is_no_motion(make_sine):
    record = make_sine()
    x = record.displacement.copy()
    x[50:120] += 5e-6
    assert motion_start(record.replace(note="flicker", displacement=x)) == pytest.approx(2.0, abs=0.02)


def test_an_encoder_that_settles_by_one_step_is_no_motion(make_sine):
    record = make_sine(rest=11.0)
    x = record.displacement.copy()
    x[50:] += 5e-6
    assert motion_start(record.replace(note="settled", displacement=x)) == pytest.approx(11.0, abs=0.02)


def test_a_record_that_never_moves_starts_at_its_end():
    t = 0.01 * np.arange(50)
    assert motion_start(Record(t, np.zeros(50), np.ones(50))) == t[-1]


def test_the_real_records(published):
    start = {record.name: motion_start(record) for record in published}
    assert all(0 <= value <= 4.0 for value in start.values())
    assert sum(value > 1.95 for value in start.values()) == 13
    at_once = {name for name, value in start.items() if value <= 0.15}
    assert at_once == {"ensaio.A.3", "ensaio.A.8", "ensaio.A.9", "ensaio.B.7"}


def test_a_position_that_runs_away_is_reported(make_sine):
    """An encoder that counts a fifth less backwards: after each cycle it stands that share of the stroke too far."""
    record = make_sine()
    steps = np.diff(record.displacement)
    lost = np.r_[record.displacement[0], record.displacement[0] + np.cumsum(np.where(steps < 0.0, 0.8 * steps, steps))]
    bad = quality(record.replace(note="loses counts", displacement=lost))
    per_cycle = 0.2 * np.ptp(record.displacement)
    assert bad.run_away == pytest.approx(per_cycle * len(cycle_bounds(record)), rel=0.15)
    assert any("runs away" in note and "encoder counts less one way" in note for note in bad.notes)
    slowly = record.replace(note="the table drifts", displacement=record.displacement + 1e-4 * record.time)
    assert quality(slowly).run_away == 0.0


def test_leaps_of_the_position_are_reported_with_their_times(make_sine):
    record = make_sine()
    at = [record.n // 3, record.n // 2]
    leapt = record.displacement.copy()
    leapt[at[0] :] += 4e-3
    leapt[at[1] :] -= 4e-3
    bad = quality(record.replace(note="slips", displacement=leapt))
    assert bad.leaps == tuple(record.time[at])
    assert any("leaps 2 times within one sample" in note for note in bad.notes)
    assert not bad.spikes


def test_false_and_flat_samples_of_the_position_are_reported(make_sine):
    record = make_sine()
    values = record.displacement.copy()
    values[record.n // 2] += np.ptp(values)
    spiked = quality(record.replace(note="a false sample", displacement=values))
    assert spiked.spikes["displacement"] == (record.time[record.n // 2],)
    assert not spiked.leaps
    top = 0.8 * record.displacement.max()
    flat = quality(record.replace(note="clipped", displacement=np.minimum(record.displacement, top)))
    assert flat.saturated["displacement"] > 100


def test_fast_motions_have_no_leaps():
    """Ramps, steps that take three samples, random motions and a gap: all move fast, none slips."""
    t = 0.005 * np.arange(2000)
    rng = np.random.default_rng(5)
    square = np.clip(60.0 * np.sin(2 * np.pi * t), -1.0, 1.0) * 0.01
    walk = np.cumsum(rng.normal(0.0, 1e-4, t.size))
    for x in (square, walk, 0.01 * np.abs((2.0 * t) % 2.0 - 1.0), 0.01 * np.sin(2 * np.pi * 15.0 * t)):
        assert not quality(Record(t, x, np.gradient(x, t) * 1e3)).leaps
    selected = np.r_[0:600, 640 : t.size]
    x = 0.01 * np.sin(2 * np.pi * t)
    assert not quality(Record(t[selected], x[selected], x[selected])).leaps
