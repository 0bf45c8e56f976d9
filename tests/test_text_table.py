"""Columns of text: units in the header or declared, delimiters and decimal marks, one-line faults."""

import numpy as np
import pytest

from dampyr.errors import FileError
from dampyr.records import read, write

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
            r"columns displacement \[mm\] and x \[N\] could all be the displacement",
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
            r"columns\['force'\] = 3 is not a column; choose .* from 0 to 2",
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


NAMES = "Time;Displacement (mm);Force (N)\n"


def stamped(times, delimiter=";"):
    return "\n".join(delimiter.join([t, f"{x:g}", f"{f:g}"]) for t, (_, x, f) in zip(times, ROWS, strict=True))


@pytest.mark.parametrize(
    ("head", "times", "expected"),
    [
        (NAMES, [f"2026-03-01T10:00:00.{k}23" for k in range(10)], 0.1 * np.arange(10)),
        (
            NAMES,
            [f"2026-12-31 23:59:{55 + k}.5" for k in range(5)] + [f"2027-01-01 00:00:0{k}.5Z" for k in range(5)],
            None,
        ),
        (NAMES, [f"10:59:5{k}" for k in range(10)], None),
        (NAMES, [f"23:59:5{5 + k},25" for k in range(5)] + [f"0:00:0{k},25" for k in range(5)], None),
        (
            "Date;" + NAMES,
            [f"2026-02-28;23:59:5{5 + k}" for k in range(5)] + [f"2026-03-01;00:00:0{k}" for k in range(5)],
            None,
        ),
        (NAMES, [f"2026-03-01T1{1 + k % 2}:00:0{k}+0{1 + k % 2}:00" for k in range(10)], None),
        (NAMES.replace("Time", "Time [hh:mm:ss]"), [f"10:00:{50 + k}" for k in range(10)], None),
    ],
    ids=["stamps", "new year", "clock", "midnight", "two columns", "zones", "a format for a unit"],
)
def test_time_stamps_are_seconds_from_the_first(tmp_path, head, times, expected):
    path = tmp_path / "a.csv"
    path.write_text(head + stamped(times))
    record = read(path)
    np.testing.assert_allclose(record.time, np.arange(10.0) if expected is None else expected, atol=1e-9)
    assert record.force == pytest.approx([row[2] for row in ROWS])
    assert record.provenance["first_sample"] == times[0].replace(";", " ")


@pytest.mark.parametrize(
    ("times", "message"),
    [
        (
            ["10:00:00"] * 5 + ["10:00:01"] * 5,
            r"lines 2 and 3 have the same time stamp \(8 such pairs\); cut out one .* where the clock is coarser",
        ),
        (
            [f"10:00:0{k}" for k in range(9)] + ["10:60:00"],
            r"line 11: '10:60:00' is not a time of day; repair or cut out",
        ),
        ([f"10:00:0{k}" for k in range(9)] + ["09:00:00"], r"time\[9\] = -3600 s does not come after 8 s"),
        (
            [f"2026-02-{20 + k}T10:00:00" for k in range(10)],
            r"line 11: '2026-02-29T10:00:00' is not a date with a time of day",
        ),
        ([f"2026-02-{10 + k}" for k in range(10)], r"the column of the time holds dates alone \(2026-02-10\)"),
    ],
)
def test_time_stamps_that_cannot_be(tmp_path, times, message):
    (tmp_path / "a.csv").write_text(NAMES + stamped(times))
    with pytest.raises(FileError, match=r"a\.csv: " + message):
        read(tmp_path / "a.csv")


def test_a_file_without_header_after_lines_of_text(tmp_path):
    said = {
        "columns": {"time": 0, "displacement": 1, "force": 2},
        "units": {"time": "s", "displacement": "mm", "force": "N"},
    }
    text = "Damper no. 3, tested in May\n500 Hz, 2 N preload, all well\n"
    for k, (before, more) in enumerate([("", {}), (text, {}), ("1 2 3 4\n", {"header": 1}), (text, {"header": 0})]):
        path = tmp_path / f"{k}.txt"
        path.write_text(before + lines(" "))
        assert read(path, **said, **more).force == pytest.approx([row[2] for row in ROWS])
    with pytest.raises(
        FileError, match=r"the header names 7 columns and the first line has 3 numbers; .*--header 0, header=0"
    ):
        read(tmp_path / "1.txt", units=said["units"])
    with pytest.raises(FileError, match=r"header = 99, but the file has 12 lines; give the line of the names, from 1"):
        read(tmp_path / "1.txt", **said, header=99)


def test_the_line_of_the_names_can_be_said(tmp_path):
    path = tmp_path / "a.dat"
    path.write_text("t x f\ns mm N\n-- -- --\nstarted by hand now\n" + lines(" "))
    assert read(path, header=1).displacement == pytest.approx([1e-3 * row[1] for row in ROWS])


def test_a_first_line_with_a_word_in_it_is_no_header(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("time [s],displacement [mm],force [N]\n0,zero,0\n" + lines(",").replace("0,", "0.001,", 1))
    with pytest.raises(FileError, match=r"line 2: 'zero' is not a number; repair or cut out the line"):
        read(path)


@pytest.mark.parametrize("unit", ["Sec", "sec"])
def test_a_testing_machine_writes_units_below_the_names(tmp_path, unit):
    path = tmp_path / "a.dat"
    names = f"Time\tAxial Displacement\tAxial Force\tTemperature\n{unit}\tmm\tkN\tdeg_C\n"
    body = "\n".join(f"{t}\t{x}\t{f / 1e3}\t21.5" for t, x, f in ROWS)
    path.write_text("Header Data:\tBlock\nDate\t3/1/2026 10:00:00\n\n" + names + body)
    record = read(
        path, columns={"displacement": "Axial Displacement", "force": "Axial Force (kN)"}, units={"time": "s"}
    )
    assert record.force == pytest.approx([row[2] for row in ROWS])
    assert record.temperature == pytest.approx(np.full(10, 21.5))


def test_session_and_specimen_go_through_comments(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(HEAD + lines(","))
    record = read(path, measurement_session="day 1", specimen="no. 7, the long one")
    again = read(write(record, tmp_path / "b.csv"))
    assert (again.measurement_session, again.specimen) == ("day 1", "no. 7, the long one")
    assert np.array_equal(again.force, record.force)
    stated = read(tmp_path / "b.csv", specimen="no. 8")
    assert (stated.specimen, stated.history[-1]) == (
        "no. 8",
        "specimen 'no. 8' as stated, 'no. 7, the long one' in the file",
    )


@pytest.mark.parametrize(
    ("encoding", "note"),
    [
        ("latin-1", "read as Latin-1 (Windows-1252) text, as it is not UTF-8"),
        ("utf-16", "read as UTF-16 text"),
        ("utf-8", None),
    ],
)
def test_a_text_that_is_no_utf_8_is_read_and_the_history_says_so(tmp_path, encoding, note):
    path = tmp_path / "a.csv"
    rows = "".join(f"{k / 10},{k % 3},{k}\n" for k in range(20))
    path.write_bytes(f"# für den Dämpfer\ntime [s],displacement [mm],force [N]\n{rows}".encode(encoding))
    record = read(path)
    assert record.force[-1] == 19.0
    assert [each for each in record.history if each.startswith("read as")] == ([note] if note else [])


def test_a_line_of_too_many_columns_is_refused_in_a_line(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("1," * 100_000 + "1\n")
    with pytest.raises(FileError, match="line 1 has more than 1000 columns") as raised:
        read(path)
    assert len(str(raised.value)) < 300


@pytest.mark.parametrize(
    "text", ["0,1;2,5;3\n", "0,1\t2,5\t3\n", "0,1 2,5 3\n", "0.1,2.5,3\n", "0.1, 2.5, 3,\n", '"0.1","2.5","3"\n']
)
def test_numbers_are_the_same_whichever_way_they_are_read(tmp_path, text):
    path = tmp_path / "a.txt"
    path.write_text(
        "".join(text.replace("0", str(k), 1) for k in range(10)) + "\n# a comment\n" + text.replace("0", "10", 1)
    )
    said = {
        "columns": {"time": 0, "displacement": 1, "force": 2},
        "units": {"time": "s", "displacement": "m", "force": "N"},
    }
    record = read(path, header=0, **said)
    assert record.time.tolist() == pytest.approx([k + 0.1 for k in range(11)])
    assert set(record.displacement) == {2.5}
    lines = path.read_text().splitlines()
    lines[8] = lines[8].replace("2,5", "2x5").replace("2.5", "2x5")
    path.write_text("\n".join(lines))
    with pytest.raises(FileError, match=r"line 9: '2x5' is not a number"):
        read(path, header=0, **said)
