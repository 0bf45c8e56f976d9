"""Samples of a file as a ground motion: units, the step of a time column, and what is refused with the file's path."""

from pathlib import Path

import numpy as np
import pytest

from dampyr.errors import FileError
from dampyr.ground_motions.samples import motion_of, step_of

PATH = Path("somewhere/motion.txt")


def test_samples_are_taken_in_their_unit_and_named_after_the_file() -> None:
    motion = motion_of(PATH, np.array([0.0, 1.0, -2.0]), 0.01, "g", "a station")
    np.testing.assert_allclose(motion.acceleration, [0.0, 9.80665, -19.6133], rtol=1e-15)
    assert (motion.dt, motion.name, motion.source) == (0.01, "motion", "a station")
    with pytest.raises(FileError, match=r"somewhere/motion\.txt: 1 of 2 samples are not finite"):
        motion_of(PATH, np.array([0.0, np.nan]), 0.01, "g", "")


def test_the_step_is_the_mean_one_wherever_the_time_begins() -> None:
    written = np.round(7.3 + 0.02 * np.arange(500), 3)  # as a file writes it
    assert step_of(PATH, written, None) == 0.02
    assert step_of(PATH, written, 0.02001) == 0.02  # within a thousandth
    with pytest.raises(FileError, match=r"dt = 0.021 s contradicts its time column, 0.02 s"):
        step_of(PATH, written, 0.021)


@pytest.mark.parametrize(
    ("time", "words"),
    [
        ([1.0], "holds 1 sample"),
        ([0.0, np.inf, 1.0], "time is not finite at sample 2"),
        ([0.0, 0.1, 0.1], r"time does not increase from sample 2 \(0.1 s\) to 3 \(0.1 s\)"),
        ([0.0, 0.1, 0.2, 0.302], "the step is 0.102 s after sample 3 but 0.100667 s on average"),
    ],
)
def test_a_time_column_of_no_even_step_is_refused(time: list[float], words: str) -> None:
    with pytest.raises(FileError, match=words):
        step_of(PATH, np.array(time), None)
