"""Files of five layouts in one folder with one reading.toml give equal records."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from tests.records.formats.test_mat import saved_7_3

from dampyr.cli import cli
from dampyr.errors import DampyrWarning
from dampyr.records import Record, read_campaign

Array = np.ndarray
T = 0.002 * np.arange(3000)
OMEGA = 2.0 * np.pi
X, V = 8.0 * np.sin(OMEGA * T), 8.0 * OMEGA * np.cos(OMEGA * T)  # mm, mm/s
F = 300.0 * np.tanh(V / 10.0) + 2.0 * V  # N

READING = """\
specimen = "no. 7"
measurement_session = {"bare*" = "2026-03-01", "clock*" = "2026-03-01", "mts*" = "2026-03-02", "[sv]*" = "2026-03-02"}
current = "*_{}A"

[[files]]
pattern = "bare_*"
units = {time = "s", displacement = "mm", force = "N"}
columns = {time = 0, displacement = 1, force = 2}

[[files]]
pattern = "clock_*"
force_sign = -1
columns = {displacement = "Displacement (mm)"}

[[files]]
pattern = "speed_*"
[files.units]
time = "ms"
velocity = "mm/s"
force = "N"

[[files]]
pattern = "v73_*"
variable = "data"
dt = "2 ms"
columns = {force = 3, displacement = 1}
units = {force = "kN", displacement = "mm"}
"""


def clock(seconds: float) -> str:
    """A time of day, from ten seconds before midnight on."""
    of_day = (86397.0 + seconds) % 86400.0
    return f"{int(of_day // 3600):02d}:{int(of_day // 60) % 60:02d}:{of_day % 60.0:06.3f}"


def rows(*columns: Array, delimiter: str = "\t") -> str:
    return "\n".join(delimiter.join(f"{value:.9g}" for value in row) for row in zip(*columns, strict=True)) + "\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "reading.toml").write_text(READING, encoding="utf-8")
    (tmp_path / "bare_10A.txt").write_text(rows(T, X, F, delimiter=" "), encoding="utf-8")
    stamped = [
        f"{clock(t)};{v:.9g};{x:.9g};{f:.9g}".replace(".", ",") for t, v, x, f in zip(T, X / 4, X, -F, strict=True)
    ]
    head = "Time;Displacement (V);Displacement (mm);Force (N)"
    (tmp_path / "clock_0x25A.csv").write_text("\n".join([head, *stamped]), encoding="utf-8")
    (tmp_path / "speed_1A.csv").write_text("Time,Speed,Load\n" + rows(1e3 * T, V, F, delimiter=","), encoding="utf-8")
    mts = (
        "MTS793|MPT|ENU|1|2|.|/|:|1|0|0|A\n\n"
        "Data Acquisition:\tTimed\tData\tTime:\t12.5\tSec\t3/1/2026 10:00:00 AM\n"
        "Station Name:\tdamper.cfg\n5 N preload, 20 mm limit\n\n"
        "Time\tStroke\tLoad\tTemperature\nSec\tmm\tkN\tdeg_F\n"
    )
    (tmp_path / "mts_0p5A.dat").write_text(mts + rows(T, X, F / 1e3, np.full(T.size, 68.0)), encoding="utf-8")
    saved_7_3(tmp_path / "v73_2A.mat", {"data": np.column_stack([np.zeros(T.size), X, V, F / 1e3]), "note": "text"})
    return tmp_path


@pytest.fixture
def records(folder: Path) -> list[Record]:
    with pytest.warns(
        DampyrWarning, match=r"^speed_1A: displacement integrated from the velocity; what became of its drift"
    ):
        return read_campaign(folder)


def test_they_are_equal_and_in_the_order_of_their_names(records: list[Record]) -> None:
    assert [r.name for r in records] == ["bare_10A", "clock_0x25A", "mts_0p5A", "speed_1A", "v73_2A"]
    for record in records:
        np.testing.assert_allclose(record.time, T, atol=1e-9)
        np.testing.assert_allclose(record.force, F, rtol=1e-8, atol=1e-5)
        # trapezoids of a sine err by (omega dt)^2/12, and its drift is judged by cycles that begin at samples
        np.testing.assert_allclose(record.displacement, 1e-3 * X, atol=2e-6 if record.name == "speed_1A" else 1e-10)


def test_inputs_sessions_and_specimens_are_what_was_said(records: list[Record]) -> None:
    assert [r.current for r in records] == [10.0, 0.25, 0.5, 1.0, 2.0]
    assert {r.specimen for r in records} == {"no. 7"}
    sessions = ["2026-03-01", "2026-03-01", "2026-03-02", "2026-03-02", "2026-03-02"]
    assert [r.measurement_session for r in records] == sessions


def test_what_was_done_is_in_the_history(records: list[Record]) -> None:
    _, stamped, machine, speed, matrix = records
    assert "time stamps as s from the first one, past midnight" in stamped.history
    assert "force turned, as its sign was declared" in stamped.history
    assert stamped.provenance["first_sample"] == "23:59:57,000"
    assert machine.temperature == pytest.approx(np.full(T.size, 20.0))
    assert "displacement integrated from the velocity by trapezoids, 0 at the first sample" in speed.history
    assert "time from the sampling interval, 0.002 s" in matrix.history


def test_the_command_shows_them(folder: Path) -> None:
    done = CliRunner().invoke(cli, ["records", str(folder)], catch_exceptions=False)
    assert done.exit_code == 0, done.stderr
    listed, by_input = done.stdout.split("By input")
    [head] = [line for line in listed.splitlines() if "session" in line]
    assert "specimen" in head
    assert "displacement integrated from the velocity; drift of" in listed
    inputs = [float(line.split()[0]) for line in by_input.splitlines() if line.split()[1:2] == ["A"]]
    assert inputs == [0.25, 0.5, 1.0, 2.0, 10.0]
    about = json.loads(CliRunner().invoke(cli, ["records", str(folder), "--json"], catch_exceptions=False).stdout)
    assert {each["specimen"] for each in about["records"]} == {"no. 7"}


def test_the_bare_file_on_the_command_line(folder: Path) -> None:
    (folder / "reading.toml").unlink()
    said = [word for pair in ("time=0", "displacement=1", "force=2") for word in ("--column", pair)]
    said += [word for pair in ("time=s", "displacement=mm", "force=N") for word in ("--unit", pair)]
    path = str(folder / "bare_10A.txt")
    [plain] = json.loads(CliRunner().invoke(cli, ["records", path, *said, "--json"]).stdout)["records"]
    assert plain["measured"]["peak_to_peak_m"] == pytest.approx(0.016, rel=1e-3)
    more = ["--force-sign", "-1", "--specimen", "no. 8", "--measurement-session", "day 2", "--cut", "2s", "--json"]
    pieces = json.loads(CliRunner().invoke(cli, ["records", path, *said, *more]).stdout)["records"]
    assert [one["name"] for one in pieces] == ["bare_10A_1", "bare_10A_2", "bare_10A_3"]
    assert {(one["specimen"], one["measurement_session"]) for one in pieces} == {("no. 8", "day 2")}
    assert all("force sign inverted?" in one["findings"][0]["words"] for one in pieces)
