"""Columns of numbers: separations, units in a header, and what is refused by name."""

import numpy as np
import pytest

from dampyr.errors import FileError
from dampyr.ground_motions import read

G = 9.80665


def text(folder, content, name="motion.txt"):
    path = folder / name
    path.write_text(content)
    return path


def test_the_other_processing_is_read_as_it_stands(ground_motion_folder):
    motion = read(ground_motion_folder / "elcentro.dat", units="g")
    assert (motion.n, motion.dt) == (2688, 0.02)
    assert motion.pga == pytest.approx(0.348737 * G, rel=1e-5)


def test_one_column_needs_its_step(tmp_path):
    path = text(tmp_path, "# a comment\n0.0\n0.1\n-0.2\n")
    assert read(path, units="g", dt=0.01).acceleration == pytest.approx(np.array([0.0, 0.1, -0.2]) * G)
    with pytest.raises(FileError, match="give the seconds between samples"):
        read(path, units="g")


@pytest.mark.parametrize("separator", [",", ";", "\t", "  ", ", "])
def test_two_columns_in_any_separation(tmp_path, separator):
    rows = "\n".join(f"{0.02 * k:.2f}{separator}{a}" for k, a in enumerate([0.0, 1.0, -2.0]))
    motion = read(text(tmp_path, rows, "motion.csv"), units="m/s^2")
    assert motion.dt == 0.02
    assert motion.acceleration.tolist() == [0.0, 1.0, -2.0]


def test_the_unit_may_stand_in_the_header(tmp_path):
    path = text(tmp_path, "time [s], acceleration [cm/s^2]\n0, 0\n0.02, 100\n", "motion.csv")
    assert read(path).acceleration.tolist() == pytest.approx([0.0, 1.0])
    with pytest.raises(FileError, match=r"says acceleration is in 'cm/s\^2', but units declares 'g'; leave it out"):
        read(path, units="g")


@pytest.mark.parametrize(
    ("content", "arguments", "message"),
    [
        ("0 1\n0.02 2\n", {}, r"no unit is known .* units='g'"),
        ("0 1\n0.02 2\n", {"units": "parsec"}, r"parsec"),
        ("0 1\n0.02 x\n", {"units": "g"}, r"line 2: 'x' is not a number; repair"),
        ("0 1\n0.02\n", {"units": "g"}, r"line 2 has 1 values and line 1 has 2"),
        (
            "0 1 2\n1 1 2\n2 1 2\n3 1 2\n",
            {"units": "g"},
            r"holds 3 columns without names, and the first one rises evenly",
        ),
        ("0 1 2\n0 1 2\n", {"units": "g"}, r"holds accelerations only; give the seconds between samples"),
        ("# nothing\n", {"units": "g"}, r"holds no numbers"),
        (
            "0 1\n0.02 2\n0.01 2\n",
            {"units": "g"},
            r"time does not increase from sample 2 \(0.02 s\) to 3 \(0.01 s\)",
        ),
        ("0 1\n0.02 2\n0.04 2\n0.09 2\n", {"units": "g"}, r"the step is 0.05 s after sample 3"),
        ("0 1\n0.02 nan\n", {"units": "g"}, r"1 of 2 samples are not finite"),
        ("nan 1\n0.02 1\n", {"units": "g"}, r"time is not finite at sample 1"),
        ("0 1\n", {"units": "g"}, r"1 sample"),
        ("0 1\n0.02 2\n", {"units": "g", "dt": 0.01}, r"contradicts its time column, 0.02 s"),
        ("t [mm],a [g]\n0,1\n20,2\n", {}, r"the unit 'mm' does not measure what 's' measures"),
    ],
)
def test_bad_columns_are_refused_by_name(tmp_path, content, arguments, message):
    with pytest.raises(FileError, match=message) as caught:
        read(text(tmp_path, content), **arguments)
    assert str(caught.value).startswith(str(tmp_path / "motion.txt"))
