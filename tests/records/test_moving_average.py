"""A moving average by brute force; what is declared of one, from numbers, texts and tables."""

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.records import Declaration, MovingAverage
from dampyr.records.conditioning.moving_average import averaged, reach_of, whole_windows


@pytest.mark.parametrize(("samples", "trailing", "reach"), [(5, False, (2, 2)), (6, False, (3, 2)), (5, True, (4, 0))])
def test_the_mean_of_each_window_by_brute_force(samples, trailing, reach):
    assert reach_of(samples, trailing) == reach
    before, after = reach
    values = np.random.default_rng(1).normal(size=(40, 3))
    expected = [values[max(i - before, 0) : i + after + 1].mean(axis=0) for i in range(40)]
    np.testing.assert_allclose(averaged(values, before, after), expected, atol=1e-13)
    np.testing.assert_allclose(averaged(values[:, 1], before, after), np.array(expected)[:, 1], atol=1e-13)
    inside = [i for i in range(40) if i - before >= 0 and i + after < 40]
    part = whole_windows(40, before, after)
    assert [part.start, part.stop - 1] == [inside[0], inside[-1]]


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        (0.3, Declaration(seconds=0.3)),
        ("0.3 s", Declaration(seconds=0.3)),
        ("0.3", Declaration(seconds=0.3)),
        ("15 samples, trailing", Declaration(samples=15, trailing=True)),
        ("0.1 periods, force", Declaration(periods=0.1, channels=("force",))),
        ("0.1 periods, not undone", Declaration(periods=0.1, undo=False)),
        ({"periods": 0.1, "channels": ["force", "velocity"]}, Declaration(periods=0.1, channels=("force", "velocity"))),
        ({"samples": 15, "trailing": True, "undo": False}, Declaration(samples=15, trailing=True, undo=False)),
    ],
)
def test_a_window_from_a_number_a_text_or_a_table(given, expected):
    assert Declaration.of(given) == expected


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (0.0, "smoothed = 0 s is not a valid window"),
        ("-3 samples", "smoothed = -3 samples is not a valid window"),
        ("2.5 samples", "smoothed = 2.5 samples is not a valid window; give a number above 0, of samples a whole one"),
        ("a tenth", "write it as in"),
        ("1..2 s", "write it as in"),
        ("0.3 s, leading", "'leading' is not among trailing, centred"),
        ({"samples": 15, "periods": 0.1}, "needs one window and has 2"),
        ({"channels": ["force"]}, "needs one window and has 0"),
        ({"periods": 0.1, "channels": ["time"]}, "'time' is not a channel that can be smoothed"),
        ({"periods": 0.1, "channels": "force"}, "is not a list of channels"),
        ({"periods": "0.1"}, "is not a number"),
        ({"periods": 0.1, "undo": 1}, "is neither true nor false"),
        ({"window": 0.1}, "'window' is not among seconds"),
        (True, "is not a valid window"),
    ],
)
def test_what_is_no_window_is_refused_with_the_repair(given, words):
    with pytest.raises(InputError, match=words.replace("(", r"\(")):
        Declaration.of(given)


@pytest.mark.parametrize("given", ["0.3 s", "15 samples, trailing", "0.1 periods, not undone, displacement, force"])
def test_a_declaration_says_all_that_is_declared(given):
    assert str(Declaration.of(given)) == given
    assert Declaration.of(str(Declaration.of(given))) == Declaration.of(given)


def test_a_window_in_s_gives_its_samples_at_any_interval():
    average = MovingAverage(0.3, "centred", ("force", "displacement"))
    assert average.reach(0.002) == (75, 74)
    assert average.reach(0.01) == (15, 14)
    assert average.without(("displacement",)) == MovingAverage(0.3, "centred", ("force",))
    assert average.without(("displacement", "force")) is None
    with pytest.raises(InputError, match="must be greater than 0"):
        MovingAverage(0.0)
