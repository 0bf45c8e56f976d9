"""The PEER format AT2, in both styles of its header."""

import numpy as np
import pytest

from dampyr.errors import FileError
from dampyr.ground_motions import read

G = 9.80665
AT2 = (
    "PEER NGA STRONG MOTION DATABASE RECORD\nSomewhere, 1/1/2000\nACCELERATION "
    "TIME SERIES IN UNITS OF G\n{header}\n{values}\n"
)
VALUES = "  .1000000E-02  -.2000000E-02   .3000000E-02\n   .4000000E-02  -.5000000E-02\n"


def at2(folder, header="NPTS=   5, DT=   .0100 SEC,", values=VALUES):
    path = folder / "motion.AT2"
    path.write_text(AT2.format(header=header, values=values))
    return path


def text(folder, content, name="motion.txt"):
    path = folder / name
    path.write_text(content)
    return path


@pytest.mark.parametrize(
    "header",
    [
        "NPTS=   5, DT=   .0100 SEC,",
        "NPTS=  5, DT= 0.01 SEC",
        "    5    0.0100    NPTS, DT",
        "5 .0100 NPTS,DT",
    ],
)
def test_at2_in_both_styles(tmp_path, header):
    motion = read(at2(tmp_path, header))
    assert motion.dt == 0.01
    assert motion.acceleration == pytest.approx(np.array([1, -2, 3, 4, -5]) * 1e-3 * G)
    assert motion.name == "motion"
    assert "Somewhere" in motion.source


@pytest.mark.parametrize(
    ("header", "values", "arguments", "message"),
    [
        ("NPTS=   7, DT=   .0100 SEC,", VALUES, {}, r"NPTS = 7 but 5 values follow"),
        ("NPTS=   4, DT=   .0100 SEC,", VALUES, {}, r"NPTS = 4 but 5 values follow"),
        ("somewhere else", VALUES, {}, r"line 4 is 'somewhere else'; it must give NPTS and DT"),
        ("NPTS=   5, DT=   .0000 SEC,", VALUES, {}, r"DT > 0"),
        (
            "NPTS=   5, DT=   .0100 SEC,",
            VALUES.replace(".3", "x.3"),
            {},
            r"line 5: 'x.3000000E-02' is not a number; repair",
        ),
        (
            "NPTS=   5, DT=   .0100 SEC,",
            VALUES.replace("-.2000000E-02", "nan"),
            {},
            r"1 of 5 samples are not finite",
        ),
        (
            "NPTS=   5, DT=   .0100 SEC,",
            VALUES,
            {"dt": 0.02},
            r"dt = 0.02 s contradicts the header's DT = 0.01 s",
        ),
        (
            "NPTS=   5, DT=   .0100 SEC,",
            VALUES,
            {"units": "m/s^2"},
            r"units = 'm/s\^2' contradict the header's 'g'",
        ),
    ],
)
def test_an_at2_that_lies_is_refused_by_name(tmp_path, header, values, arguments, message):
    with pytest.raises(FileError, match=message) as caught:
        read(at2(tmp_path, header, values), **arguments)
    assert str(caught.value).startswith(str(tmp_path / "motion.AT2"))


def test_at2_cut_short(tmp_path):
    with pytest.raises(FileError, match="has 2 lines"):
        read(text(tmp_path, "PEER\nSomewhere\n", "cut.at2"))
