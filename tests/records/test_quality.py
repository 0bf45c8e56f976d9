"""Gaps, jitter, saturation and quantisation are reported, not repaired."""

import numpy as np
import pytest

from dampyr.records import Record, cycles, quality, quantum, read_campaign


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
        np.sum(clipped.force[slice(cycles(record)[0][0], cycles(record)[-1][1])] == 250.0)
    )
    assert any("force may be saturated" in note for note in quality_report.notes)
    assert "force" not in quality(record).saturated


@pytest.mark.parametrize("step", [5e-6, 1e-3, 0.1873073])
def test_the_quantum_of_rounded_values(step):
    values = np.random.default_rng(4).normal(0, 40 * step, 2000)
    assert quantum(np.round(values / step) * step) == pytest.approx(step, rel=1e-6)
    assert quantum(values) is None
    assert quantum(np.ones(100)) is None


def test_the_real_quanta(campaign_folder):
    for record in read_campaign(campaign_folder, role=None):
        quality_report = quality(record)
        assert quality_report.quantum["displacement"] == pytest.approx(5e-6, rel=1e-6), record.name
        assert quality_report.quantum["force"] == pytest.approx(0.1873, rel=1e-3), record.name
        assert quality_report.quantum["velocity"] == pytest.approx(5e-4, rel=1e-3), record.name
        assert quality_report.notes == (), record.name
