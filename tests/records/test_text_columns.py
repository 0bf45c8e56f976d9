"""Columns of text: units in the header or declared, delimiters and decimal marks, one-line faults."""

import numpy as np
import pytest

from dampyr.errors import FileError
from dampyr.records import read

ROWS = [(0.01 * k, 2.5 * k, 10.0 * k - 20) for k in range(10)]


def lines(delimiter, decimal="."):
    return "\n".join(delimiter.join(f"{v:.6g}".replace(".", decimal) for v in row) for row in ROWS)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.csv", "time [s],displacement [mm],force [N]\n" + lines(",")),
        (
            "a.csv",
            "t (ms)\tdist (cm)\tload (kN)\n" + "\n".join(f"{1e3 * t}\t{x / 10}\t{f / 1e3}" for t, x, f in ROWS),
        ),
        ("a.csv", '"time [s]";"x [mm]";"force [N]"\n' + lines(";", ",")),
        ("a.txt", "# a bench test\n% Time [s]  Displacement [mm]  Force [N]\n" + lines("   ")),
        ("a.txt", "time (s) displacement (mm) force (N)\n" + lines(" ") + "\n\n# the end\n"),
        ("a.txt", "time [s] x [mm] f [N]\n" + lines("  ", ",")),
        ("a.csv", "\ufefftime [s],displacement [mm],force [N]\r\n" + lines(",").replace("\n", "\r\n")),
    ],
)
def test_the_same_numbers_however_they_are_written(tmp_path, name, text):
    path = tmp_path / name
    path.write_bytes(text.encode())
    record = read(path, voltage=1.0)
    assert record.time == pytest.approx([row[0] for row in ROWS])
    assert record.displacement == pytest.approx([row[1] * 1e-3 for row in ROWS])
    assert record.force == pytest.approx([row[2] for row in ROWS])
    assert record.voltage == 1.0


def test_decimal_commas_between_spaces(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("t [s] x [m] f [N]\n" + "\n".join(f"0,{k}5 {k},25 -{k},5e1" for k in range(9)))
    record = read(path)
    assert (record.time[2], record.displacement[2], record.force[2]) == (0.25, 2.25, -25.0)


def test_commas_and_spaces_are_commas(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("t [s], x [m], f [N]\n" + "\n".join(f"{k}, {k}, {k}" for k in range(9)))
    assert read(path).force[2] == 2.0


def test_units_and_columns_declared(tmp_path):
    path = tmp_path / "plain.txt"
    path.write_text(lines(" "))
    declared = {"time": "s", "displacement": "mm", "force": "N"}
    record = read(path, columns={"time": 0, "displacement": 1, "force": 2}, units=declared)
    assert record.displacement[3] == pytest.approx(7.5e-3)
    path = tmp_path / "named.csv"
    path.write_text("clock,LVDT,cell\n" + lines(","))
    record = read(path, columns={"time": "clock", "displacement": "lvdt", "force": "cell"}, units=declared)
    assert record.force[0] == -20.0


def test_all_channels(tmp_path):
    head = "time [s],displacement [mm],velocity [mm/s],force [lbf],voltage [mV],temperature [°F]\n"
    path = tmp_path / "all.csv"
    path.write_text(head + "\n".join(f"{k / 100},{k},{k},1,{1980},212" for k in range(9)))
    record = read(path)
    assert record.velocity[2] == pytest.approx(2e-3)
    assert record.force[0] == pytest.approx(4.4482216)
    assert record.voltage == pytest.approx(1.98)
    assert isinstance(record.voltage, float)
    assert record.temperature[0] == pytest.approx(100.0)


def test_a_voltage_that_changes_is_a_channel(tmp_path):
    path = tmp_path / "steps.csv"
    path.write_text("t [s],x [m],f [N],u [V]\n" + "\n".join(f"{k / 100},{k},{k},{k // 5}" for k in range(10)))
    record = read(path)
    assert np.array_equal(record.voltage, [0.0] * 5 + [1.0] * 5)
    assert record.input_value == pytest.approx(0.5)


HEAD = "time [s],displacement [mm],force [N]\n"


@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        (
            HEAD + lines(",").replace("0.04,10,20", "0.04,nan,20"),
            {},
            r"displacement\[4\] = nan m is not finite",
        ),
        (HEAD + lines(",").replace("0.04,", "0.02,"), {}, r"time\[4\] = 0.02 s does not come after 0.03 s"),
        (
            HEAD + lines(",").replace("0.04,10,20", "0.04,10"),
            {},
            r"line 6 has 2 values and line 2 has 3; repair",
        ),
        (
            HEAD + lines(",").replace("0.04,10,20", "0.04,ten,20"),
            {},
            r"line 6: 'ten' is not a number; repair",
        ),
        (HEAD.replace("[mm]", "[parsnip]") + lines(","), {}, r"unknown unit 'parsnip'; write a unit such as"),
        (HEAD.replace("[mm]", "[kg]") + lines(","), {}, r"the unit 'kg' does not measure what 'm' measures"),
        (
            HEAD.replace(" [mm]", "") + lines(","),
            {},
            r"the column 'displacement' has no unit; .*declare it: --unit displacement=m, units=",
        ),
        (
            HEAD.replace("force", "pull") + lines(","),
            {},
            r"no column is the force \(there: time, displacement, pull\)",
        ),
        (
            HEAD.replace("force", "x") + lines(","),
            {},
            r"columns displacement and x could all be the displacement",
        ),
        (
            HEAD.replace(",force [N]", "") + lines(","),
            {},
            r"the header names 2 columns and the first line has 3",
        ),
        (
            HEAD + lines(","),
            {"units": {"force": "kN"}},
            r"says force is in 'N', but units declares 'kN'; leave it",
        ),
        (
            HEAD + lines(","),
            {"columns": {"force": 3}},
            r"columns\['force'\] = 3 is no column; choose .* from 0 to 2",
        ),
        (HEAD + lines(","), {"columns": {"force": "cell"}}, r"there is no column 'cell'; choose from time, "),
        (HEAD, {}, r"has no line of numbers"),
        (HEAD + "0,0,0\n0.01,1,1", {}, r"the record has 2 samples; give at least 8"),
    ],
)
def test_faults_are_one_line_naming_the_file(tmp_path, text, options, message):
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(FileError, match=r"bad\.csv: .*" + message) as caught:
        read(path, **options)
    assert "\n" not in str(caught.value)


def test_units_in_a_line_of_their_own(tmp_path):
    path = tmp_path / "mts.txt"
    rows = "\n".join(f"{k / 100}\t{k}\t{2 * k}\t" for k in range(9))
    path.write_text(f"Time\tDisplacement\tForce\t\nsec\tmm\tkN\t\n{rows}\n")
    record = read(path)
    assert record.time[1] == 0.01
    assert record.displacement[3] == pytest.approx(3e-3)
    assert record.force[3] == pytest.approx(6e3)


def test_all_columns_without_a_unit_are_named_at_once(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("Time\tDisp\tForce [N]\n" + "\n".join(f"{k}\t{k}\t{k}" for k in range(9)))
    with pytest.raises(FileError, match=r"the columns 'Time', 'Disp' have no unit; .*--unit time=s"):
        read(path)
