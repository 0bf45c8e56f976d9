"""The PEER format AT2, in both styles of its header."""

from itertools import cycle, product

import numpy as np
import pytest
from tests.text_cases import DT, PGA, SAMPLES, ground, in_rows

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


ENDS = {"LF": "\n", "CR LF": "\r\n", "CR CR LF": "\r\r\n", "CR": "\r"}
HEADERS = (f"NPTS=  {SAMPLES}, DT= .01000 SEC", f"{SAMPLES}    0.0100    NPTS, DT", f"NPTS= {SAMPLES}  DT= 1.0E-02 SEC")
NUMBERS = {
    "E": lambda value: f"{value:15.7E}",
    "D": lambda value: f"{value:15.7E}".replace("E", "D"),
    "F": lambda value: f"{value:11.5f}",
    "decimal commas": lambda value: f"{value:15.7E}".replace(".", ","),
    "touching": lambda value: f"{value:8.5f}",
}
UNIT_LINES = cycle(
    ["ACCELERATION TIME HISTORY IN UNITS OF G", "The units are (g)", "ACCELERATION IN UNITS OF G.", "UNITS: CM/SEC/SEC"]
)
VARIANTS = [
    (end, header, numbers, unit, 5 + 3 * (k % 2), k % 3 == 0)
    for k, ((end, header, numbers), unit) in enumerate(zip(product(ENDS, HEADERS, NUMBERS), UNIT_LINES, strict=False))
]


@pytest.mark.parametrize(("end", "header", "numbers", "unit", "per_line", "blank"), VARIANTS)
def test_sixty_variants_of_at2(tmp_path, end, header, numbers, unit, per_line, blank):
    """Line ends, both styles of the header, exponents, decimal commas, fields that touch, 5 or 8 a line, a blank first line."""
    assert len(VARIANTS) == 60
    of_g = 1.0 if "CM" not in unit else 100.0 * G
    values = [NUMBERS[numbers](value * (of_g if numbers != "touching" else 1.0)) for value in ground()]
    unit = "IN UNITS OF G" if numbers == "touching" else unit
    header = header.replace(".", ",") if numbers == "decimal commas" and "NPTS=" in header else header
    text = "\n" * blank + f"PEER STRONG MOTION DATABASE RECORD\nX 01/01/00, X, 000\n{unit}\n{header}\n"
    path = tmp_path / "motion.AT2"
    path.write_bytes((text + in_rows(values, per_line)).replace("\n", ENDS[end]).encode())
    motion = read(path)
    assert (motion.n, motion.dt) == (SAMPLES, DT)
    assert motion.pga == pytest.approx(PGA * G, rel=1e-6 if numbers != "F" else 2e-5)
    assert motion.acceleration == pytest.approx(ground() * G, abs=1e-6 * G)
    assert motion.history == ("decimal commas",) * (numbers == "decimal commas") + touching_note(values, per_line)


def touching_note(values, per_line):
    """What the history says where numbers touch."""
    width = len(values[0])
    touch = any(value[0] != " " for k, value in enumerate(values) if k % per_line)
    return (f"fields of {width} characters",) * touch


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda lines: lines[:-3], r"NPTS = 1203 but \d+ values follow"),
        (lambda lines: [*lines[:20], *lines[21:]], "NPTS = 1203 but 1198 values follow"),
        (lambda lines: [*lines[:20], lines[20], *lines[20:]], "NPTS = 1203 but 1208 values follow"),
        (lambda lines: [*lines[:20], lines[20][:40], *lines[21:]], "line 21 has 3 values and line 5 has 5; repair the line"),
        (lambda lines: [*lines[:20], lines[20].replace(".", ",", 1), *lines[21:]], "line 21: '.*,.*' is not a number"),
        (lambda lines: [*lines[:20], lines[20].replace("E", "X", 1), *lines[21:]], "line 21: '.*X.*' is not a number; repair"),
        (lambda lines: lines[:2] + lines[3:], r"line 4 is '.*'; it must give NPTS and DT"),
        (lambda lines: [*lines[:2], "no unit", *lines[3:]], "no unit is known for the acceleration; declare it, such as"),
        (lambda lines: [*lines[:3], "NPTS= 1O03, DT= .01 SEC", *lines[4:]], "line 4 is 'NPTS= 1O03.*'; it must give NPTS"),
    ],
)  # fmt: skip
def test_a_mutated_at2_is_refused_at_its_place(tmp_path, change, message):
    head = [
        "PEER STRONG MOTION DATABASE RECORD",
        "X 01/01/00, X, 000",
        "ACCELERATION TIME HISTORY IN UNITS OF G",
        HEADERS[0],
    ]
    lines = [*head, *in_rows([NUMBERS["E"](value) for value in ground()], 5).splitlines()]
    path = tmp_path / "motion.AT2"
    path.write_text("\n".join(lines))
    assert read(path).pga == pytest.approx(PGA * G)
    path.write_text("\n".join(change(lines)))
    with pytest.raises(FileError, match=message) as caught:
        read(path)
    assert "\n" not in str(caught.value)
