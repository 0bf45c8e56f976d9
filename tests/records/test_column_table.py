"""Channels, units and inputs of a table of columns: found by names, declared, or named all at once where they lack."""

import numpy as np
import pytest

from dampyr.errors import FileError, InputError
from dampyr.records import ReadOptions, read, read_campaign, write
from dampyr.records.files.column_table import guess_channels
from dampyr.text_table import read_table

ROWS = [(0.01 * k, 2.5 * k, 10.0 * k - 20) for k in range(10)]


def lines(delimiter, decimal="."):
    return "\n".join(delimiter.join(f"{v:.6g}".replace(".", decimal) for v in row) for row in ROWS)


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


def test_all_columns_without_a_unit_are_named_at_once(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("Time\tDisp\tForce [N]\n" + "\n".join(f"{k}\t{k}\t{k}" for k in range(9)))
    with pytest.raises(FileError, match=r"the columns 'Time', 'Disp' have no unit; .*--unit time=s"):
        read(path)


NAMES = "Time;Displacement (mm);Force (N)\n"


def stamped(times, delimiter=";"):
    return "\n".join(delimiter.join([t, f"{x:g}", f"{f:g}"]) for t, (_, x, f) in zip(times, ROWS, strict=True))


def test_an_interval_in_the_place_of_a_coarse_clock(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(NAMES + stamped(["10:00:00"] * 10))
    assert read(path, columns={"time": "-"}, dt="5 ms").time == pytest.approx(0.005 * np.arange(10))
    record = read(path, dt=0.005)  # a clock that stands still does not contradict it
    assert record.time == pytest.approx(0.005 * np.arange(10))
    assert "time from the sampling interval, 0.005 s, in the place of the stamps 'Time'" in record.history
    path.write_text(NAMES + stamped([f"10:00:0{k}" for k in range(10)]))
    with pytest.raises(
        FileError,
        match=r"dt = 0.005 s was given, but the column 'Time' is the time and steps by 1 s on average; correct dt",
    ):
        read(path, dt=0.005)
    path.write_text(NAMES + stamped(["10:00:00"] * 10))
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
    path.write_text("Uhr [s];Hub [mm];Zug [kN]\n" + lines(";", ","))
    words = r"no column is the time, the displacement or the force \(there: Uhr, Hub, Zug\); declare which, "
    options = r"--column time=NAME --column displacement=NAME --column force=NAME or columns=.*--dt 0.001"
    with pytest.raises(FileError, match=words + options):
        read(path)
    with pytest.raises(
        FileError, match=r"no column is the displacement or the force .*, --column displacement=NAME --c"
    ):
        read(path, columns={"time": "Uhr"})


def test_an_encoding_and_a_delimiter_are_declared(tmp_path):
    names = "時間 [s]|変位 [mm]|荷重 [N]\n"
    path = tmp_path / "a.txt"
    path.write_bytes((names + lines("|")).encode("shift_jis"))
    record = read(path, encoding="shift_jis", delimiter="|")
    assert record.displacement[3] == pytest.approx(7.5e-3)
    assert "read as shift_jis text, as declared" in record.history
    with pytest.raises(FileError, match=r"is not ascii text \(byte 0\); correct the encoding, or leave it out"):
        read(path, encoding="ascii")
    with pytest.raises(FileError, match="has no line of numbers parted by ';', as declared; give a header"):
        read(path, encoding="shift_jis", delimiter=";")
    path.write_bytes((names + lines("|")).encode("utf-16-le"))  # without its mark
    (tmp_path / "reading.toml").write_text('encoding = "utf-16-le"\ndelimiter = "|"\nno_input = true')
    assert read_campaign(tmp_path)[0].force[0] == -20.0
    (tmp_path / "reading.toml").unlink()
    assert read_campaign(tmp_path, encoding="utf-16-le", delimiter="|", voltage=1.0)[0].voltage == 1.0
    with pytest.raises(
        FileError, match="delimiter = ';' was given, but a NetCDF file names its variables; leave it out"
    ):
        read(write(record, tmp_path / "a.nc"), delimiter=";")


def test_a_declared_comma_and_white_space(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("time [s],displacement [mm],force [N]\n" + lines(" , "))
    assert read(path, delimiter=",").force[0] == -20.0
    path.write_text("t [s]   x [mm]   f [N]\n" + lines("   "))
    assert read(path, delimiter="blank").force[1] == -10.0
    with pytest.raises(InputError, match=r"delimiter = '/' does not part columns; choose from ',' ';' 'tab'"):
        read(path, delimiter="/")


@pytest.mark.parametrize(
    ("header", "channels"),
    [
        (
            "Zeit [s],Weg [mm],Kraft [kN],Spannung [V],Geschwindigkeit [mm/s]",
            "time displacement force voltage velocity",
        ),
        (
            "tempo (s),deslocamento (mm),força (kN),tensão (V),velocidade (mm/s)",
            "time displacement force voltage velocity",
        ),
        ("t/s,x/mm,F/kN,U/V,v/mm/s", "time displacement force voltage velocity"),
        ("Zeit in s,Weg in mm,Kraft in kN,Strom in A,T [degC]", "time displacement force current -"),
        ("t [s],Weg [mm],F [kN],Spannung [MPa],Tensão [N]", "time displacement force - -"),  # stresses and a pull
        ("time,stress/strain [mm],Kraft in Richtung,U,tension", "time - - voltage -"),  # no units behind them
    ],
)
def test_columns_are_known_by_their_usual_names_in_other_languages(tmp_path, header, channels):
    rows = [(0.01 * k, 8 * np.sin(k / 9), 0.3 * np.cos(k / 9), 1.98, 3.0) for k in range(400)]
    path = tmp_path / "a.csv"
    path.write_text("\n".join([header, *(",".join(f"{value:.5f}" for value in row) for row in rows)]), "utf-8")
    table = read_table(path, ReadOptions(), by_number=True)
    known = {column: channel for channel, column in guess_channels(path, table).items()}
    assert [known.get(k, "-") for k in range(5)] == channels.split()
    if "force" in known.values():
        assert read(path).force.max() == pytest.approx(300.0)
