"""Bins of a live rig: no peak is lost, whatever the sampling rate, and memory does not grow."""

from dataclasses import replace

import numpy as np
import pytest

from dampyr.console.decimation import BINS, COLUMNS, HISTORY, MinMaxBins, as_lists
from dampyr.models.numerics.differentiation import differentiate
from dampyr.rig.firmware.protocol import Fault, State, Status
from dampyr.rig.interlock import Samples

COUNT = 1e-5  # m of the encoder
REST = Status(0, State.ARMED, Fault(0), 0, 0, 0, True, True, True, 64, 0, 0)


def block(first: int, x: np.ndarray, force: np.ndarray, rate: float) -> Samples:
    """A block as the acquisition gives it."""
    n = len(x)
    time = np.arange(first, first + n) / rate
    return Samples(first, time, x, force, None, force[None] / 613, np.zeros(n, int), np.zeros(n), REST)


def fed(rate: float, x: np.ndarray, force: np.ndarray, blocks: list[int]) -> MinMaxBins:
    """Strips that took the blocks of the given lengths one after the other, from the start again and again."""
    strips, first, k = MinMaxBins(rate), 0, 0
    while first < len(x):
        n = min(blocks[k % len(blocks)], len(x) - first)
        strips.take(block(first, x[first : first + n], force[first : first + n], rate), 20.0, 0.0)
        first, k = first + n, k + 1
    return strips


def columns(strips: MinMaxBins) -> dict[str, np.ndarray]:
    return dict(zip(COLUMNS, strips.since(0)[1].T, strict=True))


@pytest.mark.parametrize(("rate", "blocks"), [(1000.0, [40]), (10_000.0, [400]), (1000.0, [7, 13, 1, 64]), (50.0, [2])])
def test_a_spike_of_one_sample_is_seen_whatever_the_rate_and_the_blocks(rate: float, blocks: list[int]) -> None:
    n = int(5 * rate)
    force = np.zeros(n)
    force[n // 3], force[n // 2] = 777.0, -333.0
    column_values = columns(fed(rate, np.zeros(n), force, blocks))
    assert column_values["force_high"].max() == 777.0
    assert column_values["force_low"].min() == -333.0
    at = float(column_values["time"][column_values["force_high"].argmax()])
    assert at - 1e-9 <= (n // 3) / rate < at + max(1 / BINS, 1 / rate) + 1e-9


@pytest.mark.parametrize("rate", [1000.0, 10_000.0])
def test_as_many_bins_a_second_from_a_fast_board_as_from_a_slow_one(rate: float) -> None:
    n = int(4 * rate)
    strips = fed(rate, np.zeros(n), np.zeros(n), [int(0.04 * rate)])
    assert strips.count == 4 * BINS


@pytest.mark.parametrize(("rate", "blocks"), [(1000.0, [40]), (1000.0, [7, 13, 1, 64]), (1000.0, [2000]), (50.0, [2])])
def test_the_velocity_is_that_of_a_record_and_no_staircase_where_the_table_turns(
    rate: float, blocks: list[int]
) -> None:
    t = np.arange(int(4 * rate)) / rate
    x = np.round(0.008 * np.sin(2 * np.pi * t) / COUNT) * COUNT  # as an encoder shows it
    strips = fed(rate, x, np.zeros_like(x), blocks)
    column_values, lag = columns(strips), strips.lag
    middle = column_values["time"][:-lag] + 0.5 * (strips.size - 1) / rate
    exact = 1e3 * 0.008 * 2 * np.pi * np.cos(2 * np.pi * middle)
    velocity = column_values["velocity"][lag:]
    assert np.isnan(velocity[:lag]).all()  # there is nothing before
    assert np.abs(velocity - exact)[lag:].max() < (0.1 if rate > 100.0 else 0.3)  # mm/s of 50
    turning = np.abs(exact) < 5.0
    turning[:lag] = False
    record = differentiate(t, x, 10.0)[strips.size // 2 :: strips.size][:-lag] * 1e3
    assert np.abs(velocity - record)[turning].max() < 0.2  # half a sample apart; a count in 10 ms is 1 mm/s


def test_what_a_drive_asks_for_comes_beside_what_is_measured() -> None:
    strips, t = MinMaxBins(1000.0), np.arange(40) / 1000.0
    strips.take(block(0, np.zeros(40), np.zeros(40), 1000.0), 20.0, 0.0)
    strips.take(replace(block(40, np.zeros(40), np.zeros(40), 1000.0), target=0.002 + 0.1 * t), 20.0, 0.0)
    target = columns(strips)["target"]
    assert np.isnan(target[:4]).all()
    np.testing.assert_allclose(target[4:], 2.0 + 100.0 * np.array([0.005, 0.015, 0.025, 0.035]))
    assert as_lists(strips.since(0)[1])["target"][:4] == [None] * 4


def test_loops_go_through_the_samples_of_least_and_greatest_force_in_their_order() -> None:
    rng = np.random.default_rng(1)
    x, force = np.cumsum(rng.normal(size=1000)) * 1e-6, rng.normal(size=1000)
    column_values = columns(fed(1000.0, x, force, [40]))
    for k in range(len(column_values["time"])):
        part = slice(10 * k, 10 * k + 10)
        low, high = int(force[part].argmin()), int(force[part].argmax())
        first, second = sorted((low, high))
        assert column_values["force_first"][k] == force[part][first]
        assert column_values["force_second"][k] == force[part][second]
        assert column_values["x_first"][k] == pytest.approx(1e3 * x[part][first])


def test_memory_is_flat_and_a_reader_that_was_away_gets_what_is_left() -> None:
    strips = fed(1000.0, np.zeros(60_000), np.zeros(60_000), [40])
    held = sum(each.nbytes for each in vars(strips).values() if isinstance(each, np.ndarray))
    assert held < 1_000_000
    number, rows = strips.since(0)
    assert len(rows) == HISTORY * BINS
    assert rows[-1, 0] == pytest.approx((number - 1) / BINS)
    assert strips.since(number)[1].shape == (0, len(COLUMNS))


def test_a_new_run_begins_after_a_gap() -> None:
    strips = MinMaxBins(1000.0)
    strips.take(block(0, np.zeros(40), np.arange(40.0), 1000.0), 20.0, 5.0)
    strips.take(block(0, np.zeros(40), np.zeros(40), 1000.0), 20.0, 9.0)
    column_values = columns(strips)
    assert column_values["force_high"][:4].tolist() == [9.0, 19.0, 29.0, 39.0]
    assert np.isnan(column_values["force_high"][4])
    assert column_values["time"].tolist() == pytest.approx([5.0, 5.01, 5.02, 5.03, 9.0, 9.0, 9.01, 9.02, 9.03])
    assert as_lists(strips.since(0)[1])["force_high"][4] is None
