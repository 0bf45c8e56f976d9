"""Offset of the force: the mean over whole cycles, removed only when asked, and kept in the history."""

import numpy as np
import pytest

from dampyr.records import Record, remove_offset
from dampyr.records.conditioning.force_offset import mean_force


def test_the_offset_is_the_mean_over_whole_cycles_not_over_the_record(make_sine):
    record = make_sine(rest=4.0, offset=120.0)
    at_rest = record.replace(note="gas", force=np.where(record.time < 4.0, 70.0, record.force))
    assert abs(np.mean(at_rest.force) - 120.0) > 10
    assert mean_force(at_rest) == pytest.approx(120.0, abs=0.5)
    removed = remove_offset(at_rest)
    assert mean_force(removed) == pytest.approx(0.0, abs=1e-9)
    assert float(removed.provenance["force_offset_n"]) == mean_force(at_rest)
    assert "mean over whole cycles" in removed.history[-1]
    assert remove_offset(record, 100.0).force == pytest.approx(record.force - 100.0)


def test_uneven_sampling_does_not_bias_the_offset(make_sine):
    record = make_sine(duration=30.0, dt=0.002)
    selected = np.flatnonzero(
        (record.force > 120.0) | (np.arange(record.n) % 5 == 0)
    )  # the upper half sampled more often
    thinned = Record(record.time[selected], record.displacement[selected], record.force[selected])
    assert mean_force(thinned) == pytest.approx(120.0, abs=1.0)
    assert abs(np.mean(thinned.force) - 120.0) > 20


def test_the_real_offsets(published_fits):
    offsets = [mean_force(record) for record in published_fits]
    assert 102 < min(offsets) < 110
    assert 138 < max(offsets) < 142
