"""The Uno's clock against the board's, from pairs that are made here: its true ratio is known."""

import numpy as np
import pytest

from dampyr.rig import uno_clock
from dampyr.rig.uno_clock import ClockRatio, UnoClock

BLOCK = 0.04


def uneven(rng: np.random.Generator, n: int) -> np.ndarray:
    """s of a line between 1 and 16 ms."""
    return rng.uniform(0.001, 0.016, n)


def heard(
    clock: UnoClock, ratio: float, seconds: float, late: np.ndarray, begin: float = 7.0, first: float = 0.0
) -> None:
    """Pairs of ``seconds``, with the Uno's time in whole milliseconds, ``late`` (n,) s on the line."""
    for k in range(round(seconds / BLOCK)):
        t = first + (k + 1) * BLOCK
        clock.take(t, int(np.floor(1e3 * (begin + ratio * (t + late[k])))) % 2**32)


@pytest.mark.parametrize("ppm", [0.0, 500.0, -500.0, 2000.0, -2000.0, 5000.0, -5000.0])
def test_the_ratio_is_known_to_50_ppm_within_half_a_minute_and_its_uncertainty_holds(ppm: float) -> None:
    ratio, off = 1.0 - 1e-6 * ppm, []
    for seed in range(30):
        clock = UnoClock()
        heard(clock, ratio, 30.0, uneven(np.random.default_rng(seed), 750))
        assert clock.ratio.known
        off.append((clock.ratio.value - ratio) / clock.ratio.uncertainty)
    assert np.abs(off).max() < 3.5
    assert np.sqrt(np.mean(np.square(off))) < 1.3


def test_the_uncertainty_holds_for_a_latency_that_is_not_random() -> None:
    """An adapter that hands over what has come every 16 ms beats with blocks of 40.3 ms of a host."""
    off = []
    for begin in np.linspace(0.0, 0.016, 20):
        clock = UnoClock()
        for k in range(1, 600):
            t = 0.0403 * k
            late = 0.016 * np.ceil((t + begin) / 0.016) - (t + begin)
            clock.take(t, int(1e3 * (t + late)))
        off.append((clock.ratio.value - 1.0) / clock.ratio.uncertainty)
    assert np.sqrt(np.mean(np.square(off))) < 1.3


def test_what_was_never_compared_may_be_off_by_the_tolerance_of_a_resonator() -> None:
    assert ClockRatio() == ClockRatio(1.0, 0.003)
    assert not ClockRatio().known
    assert str(ClockRatio(0.9985, 1.2e-5)) == ("the Uno's clock is 1500 ppm slow against the board's, known to 12 ppm")


def test_the_unos_32_bits_begin_anew() -> None:
    clock = UnoClock()
    heard(clock, 1.0, 30.0, np.zeros(750), begin=2**32 / 1e3 - 10.0)
    assert clock.ratio.value == pytest.approx(1.0, abs=3e-5)
    assert clock.seconds_at(5000) == pytest.approx(15.0, abs=0.002)


def test_times_of_the_uno_are_put_on_the_boards_clock_by_its_promptest_answers() -> None:
    clock = UnoClock()
    heard(clock, 0.998, 30.0, uneven(np.random.default_rng(3), 750))
    assert clock.seconds_at(1e3 * (7.0 + 0.998 * 12.0)) == pytest.approx(12.0 - 0.0017, abs=0.001)
    assert clock.latency == pytest.approx(0.0075, abs=0.001)


def test_it_is_kept_where_the_board_begins_to_count_anew() -> None:
    clock = UnoClock()
    heard(clock, 0.9985, 60.0, uneven(np.random.default_rng(1), 1500))
    before = clock.ratio
    clock.restart()
    assert clock.ratio == before
    heard(clock, 0.9985, 2.0, uneven(np.random.default_rng(2), 50), begin=99.0)
    assert clock.ratio.known  # two seconds alone tell less than 500 ppm
    assert abs(clock.ratio.value - 0.9985) < 3.0 * clock.ratio.uncertainty


def test_an_uno_that_was_changed_between_two_armings_is_not_taken_for_the_one_before() -> None:
    clock = UnoClock()
    heard(clock, 0.97, 30.0, uneven(np.random.default_rng(1), 750))
    assert "3 % slow" in clock.fault
    clock.restart()
    assert not clock.fault
    heard(clock, 1.001, 30.0, uneven(np.random.default_rng(2), 750), begin=0.1)
    assert abs(clock.ratio.value - 1.001) < 3.0 * clock.ratio.uncertainty
    assert not clock.fault


def test_a_clock_that_warms_is_followed_and_no_fault() -> None:
    """By 10 ppm/K, 20 K in five minutes."""
    rng, clock, begin = np.random.default_rng(5), UnoClock(), 0.0
    for k in range(1, 7500):
        t = k * BLOCK
        ratio = 1.0 - 1e-6 * (1500.0 + 200.0 * t / 300.0)
        begin += ratio * BLOCK
        clock.take(t, int(1e3 * (begin + rng.uniform(0.001, 0.016))))
        assert clock.fault == ""
    assert abs(clock.ratio.value - ratio) < uno_clock.KNOWN


@pytest.mark.parametrize(("ratio", "words"), [(0.985, "1.5 % slow"), (1.02, "2 % fast"), (0.125, "87.5 % slow")])
def test_a_clock_that_no_resonator_has_is_a_fault(ratio: float, words: str) -> None:
    clock = UnoClock()
    heard(clock, ratio, 20.0, uneven(np.random.default_rng(0), 500))
    assert words in clock.fault
    assert "look at the Uno's clock" in clock.fault


@pytest.mark.parametrize("change", [0.004, -0.004])
def test_a_ratio_that_jumps_is_a_fault(change: float) -> None:
    rng, clock, begin, found = np.random.default_rng(0), UnoClock(), 0.0, []
    for k in range(1, 750):
        t = k * BLOCK
        begin += BLOCK * (1.0 + (change if t > 20.0 else 0.0))
        clock.take(t, int(1e3 * (begin + rng.uniform(0.001, 0.016))))
        if fault := clock.fault:
            found.append((t, fault))
    assert 20.0 < found[0][0] < 26.0
    assert "has changed by" in found[0][1]
