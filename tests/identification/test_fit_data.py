"""What of a record is fitted: its first part, its weight, and whole windows."""

from dataclasses import replace

import pytest
from tests.identification.smoothed_records import SAMPLES, records, smoothed

from dampyr.identification.search.fit_data import piece, thinned, weighted


def test_records_weigh_by_the_samples_that_are_compared() -> None:
    plain, other, *_ = records(1.0)
    pieces = [piece(plain, None), piece(smoothed(other, 101), None)]
    for one, by_record in zip(pieces, weighted(pieces, "records"), strict=True):
        share = float(by_record.weight[0] ** 2 * one.spread**2) * (one.comparable.stop - one.comparable.start)
        assert share == pytest.approx(sum(p.count for p in pieces) / 2)


def test_parts_of_a_smoothed_record_hold_whole_windows() -> None:
    one = piece(smoothed(records()[0]), None)
    assert thinned(one, 100) is one
    assert one.shortest == 4 * SAMPLES
    ordinary = replace(one, average=None)
    assert ordinary.shortest == 0
    assert thinned(ordinary, 100).t.size <= 100
    assert ordinary.comparable == slice(0, one.t.size)
