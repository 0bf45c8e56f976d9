"""What of a record is fitted: its first part, its weight, and whole windows."""

from dataclasses import replace

import numpy as np
import pytest
from tests.identification.smoothed_records import SAMPLES, records, smoothed
from tests.identification.synthetic import DAHL, sine

from dampyr.identification.fits.least_squares import prepared
from dampyr.identification.search.fit_data import first_part, piece, thinned, weighted


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


def test_the_first_part_holds_the_motion_or_it_is_the_whole() -> None:
    one = prepared("dahl", [sine(DAHL, 0.0, seconds=60.0)]).pieces[0]
    assert first_part(one, 1500).t.size == 1500
    growing = replace(one, x=one.x * np.linspace(0.0, 1.0, one.t.size), v=one.v * np.linspace(0.0, 1.0, one.t.size))
    assert first_part(growing, 1500).t.size == growing.t.size
    late = replace(one, x=np.where(one.t < 20.0, 0.1 * one.x, one.x), v=np.where(one.t < 20.0, 0.1 * one.v, one.v))
    assert first_part(late, 1500).t.size == 6000
