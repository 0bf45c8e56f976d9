"""Columns of text: units in the header or declared, delimiters and decimal marks, one-line faults."""

import numpy as np
import pytest

from dampyr.errors import FileError, InputError
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


def test_all_columns_without_a_unit_are_named_at_once(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("Time\tDisp\tForce [N]\n" + "\n".join(f"{k}\t{k}\t{k}" for k in range(9)))
    with pytest.raises(FileError, match=r"the columns 'Time', 'Disp' have no unit; .*--unit time=s"):
        read(path)


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
            r"lines 2 and 3 have the same time stamp \(8 such pairs\): the clock is coarser",
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


def test_an_interval_in_the_place_of_a_coarse_clock(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(NAMES + stamped(["10:00:00"] * 10))
    assert read(path, columns={"time": "-"}, dt="5 ms").time == pytest.approx(0.005 * np.arange(10))
    with pytest.raises(
        FileError, match=r"dt = 0.005 s was given, but the column 'Time' is the time; leave one of them out"
    ):
        read(path, dt=0.005)
    with pytest.raises(FileError, match=r"the column of the force holds '10:00:00', which is not a number"):
        read(path, columns={"force": 0, "time": None}, dt=0.005)


def test_a_column_by_its_full_header(tmp_path):
    path = tmp_path / "a.csv"
    head = "time [s],Displacement (V),Displacement (mm),force [N]\n"
    path.write_text(head + "\n".join(f"{t},{x / 4},{x},{f}" for t, x, f in ROWS))
    for said in ("Displacement (mm)", "displacement [MM]", 2, "2"):
        assert read(path, columns={"displacement": said}).displacement == pytest.approx([1e-3 * row[1] for row in ROWS])
    with pytest.raises(
        FileError, match=r"columns Displacement \[V\] and Displacement \[mm\] could all be the displacement"
    ):
        read(path)
    both = r"2 columns are called 'Displacement' \('Displacement \[V\]' is number 1 and 'Displacement \[mm\]' is number 2\)"
    with pytest.raises(FileError, match=both):
        read(path, columns={"displacement": "Displacement"})
    with pytest.raises(
        FileError, match=r"there is no column 'Displacement \(in\)'; choose from time \[s\], Displacement \[V\], "
    ):
        read(path, columns={"displacement": "Displacement (in)"})
    with pytest.raises(FileError, match=r"the column 0 is declared as the time and as the force; name two columns"):
        read(path, columns={"displacement": 2, "time": 0, "force": 0})


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


@pytest.mark.parametrize(("unit", "value"), [("degF", 68.0), ("K", 293.15), ("C", 20.0), ("deg F", 68.0), ("°C", 20.0)])
def test_a_temperature_in_its_units(tmp_path, unit, value):
    path = tmp_path / "a.csv"
    path.write_text(f"t [s],x [mm],f [N],temp [{unit}]\n" + "\n".join(f"{t},{x},{f},{value}" for t, x, f in ROWS))
    assert read(path).temperature == pytest.approx(np.full(10, 20.0))
    path.write_text("t [s],x [mm],f [N],temp\n" + "\n".join(f"{t},{x},{f},{value}" for t, x, f in ROWS))
    assert read(path, units={"temperature": unit}).temperature == pytest.approx(np.full(10, 20.0))


def test_the_sign_of_the_force_is_turned_where_it_is_declared(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(HEAD + lines(","))
    plain, turned = read(path), read(path, force_sign=-1)
    assert np.array_equal(turned.force, -plain.force)
    assert turned.history[-1] == "force turned, as its sign was declared"
    assert np.array_equal(read(path, force_sign=1).force, plain.force)
    with pytest.raises(InputError, match=r"force_sign = -2 is not allowed; it must be -1, which turns the force, or 1"):
        read(path, force_sign=-2)


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


def test_an_empty_cell_is_wrong_only_where_a_channel_has_it(tmp_path):
    path = tmp_path / "a.csv"
    rows = [f"{t},{x},{'3000' if k == 0 else ''},{f}" for k, (t, x, f) in enumerate(ROWS)]
    path.write_text("time [s],displacement [mm],fs [Hz],force [N]\n" + "\n".join(rows))
    assert read(path).force == pytest.approx([row[2] for row in ROWS])
    rows[4] = rows[4].replace(",10.0,", ",,")
    path.write_text("time [s],displacement [mm],fs [Hz],force [N]\n" + "\n".join(rows))
    with pytest.raises(FileError, match=r"line 6: the cell of the displacement is empty; repair or cut out the line"):
        read(path)


def test_every_channel_that_no_column_is_stands_in_one_message(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("Zeit [s];Weg [mm];Kraft [kN]\n" + lines(";", ","))
    words = r"no column is the time, the displacement or the force \(there: Zeit, Weg, Kraft\); declare which, "
    options = r"--column time=NAME --column displacement=NAME --column force=NAME or columns=.*--dt 0.001"
    with pytest.raises(FileError, match=words + options):
        read(path)
    with pytest.raises(
        FileError, match=r"no column is the displacement or the force .*, --column displacement=NAME --c"
    ):
        read(path, columns={"time": "Zeit"})
