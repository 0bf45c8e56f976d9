"""Numbers as people read them."""

import math

import pytest

from dampyr.phrases import with_reach


@pytest.mark.parametrize(
    ("value", "reach", "words"),
    [
        (14.99, 15.2, "15 ± 15"),
        (12.71, 2.98, "12.7 ± 3.0"),
        (0.8509, 0.0512, "0.851 ± 0.051"),
        (1.2996, 0.0033, "1.2996 ± 0.0033"),
        (9.9961, 0.0996, "10.00 ± 0.10"),
        (12345.6, 1234.0, "12300 ± 1200"),
        (-0.42, 0.061, "-0.420 ± 0.061"),
        (2.5e-7, 3.1e-9, "2.5e-07 ± 3.1e-09"),
        (4.0, 0.0, "4 ± 0"),
        (4.0, math.inf, "4 ± inf"),
    ],
)
def test_a_value_has_no_more_digits_than_its_interval(value: float, reach: float, words: str) -> None:
    assert with_reach(value, reach) == words
