"""Bad input through the command line: one line that names the file, the value and the repair; exit code 2; no traceback."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from dampyr.cli import cli
from dampyr.models import Damper, Polynomial
from dampyr.records import Record, write


def dampyr(*arguments: str | Path) -> Result:
    """The command in this process; below, some cases run as a user runs them."""
    return CliRunner().invoke(cli, [*map(str, arguments)])


def in_a_process(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    """The command as a user runs it."""
    command = [sys.executable, "-m", "dampyr", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def refused(done: Result | subprocess.CompletedProcess[str]) -> str:
    """The one line of an orderly refusal."""
    assert (done.exit_code if isinstance(done, Result) else done.returncode) == 2, done.stderr
    assert "Traceback" not in done.stderr
    lines = [line for line in done.stderr.splitlines() if not line.lstrip()[:1].isdigit()]
    assert len(lines) == 1, done.stderr
    assert lines[0].startswith("dampyr: ")
    assert done.stdout == ""
    return lines[0]


def mat(path: Path, **changes: object) -> Path:
    """A file like the campaign's, with something changed or taken away (None)."""
    from scipy.io import savemat

    t = np.arange(300) * 0.01
    x, f = 5.0 * np.sin(6.0 * t), 50.0 * np.sign(np.cos(6.0 * t))
    values = {"Ts": 0.01, "dist": x, "forc": f, "x_F": np.column_stack((x, np.gradient(x, t), f))} | changes
    savemat(path, {name: value for name, value in values.items() if value is not None})
    return path


def csv(path: Path, header: str = "time [s],displacement [mm],force [N]", swap: bool = False) -> Path:
    t = np.arange(300) * 0.01
    rows = np.column_stack((t, 5.0 * np.sin(6.0 * t), 50.0 * np.cos(6.0 * t)))
    if swap:
        rows[[100, 101]] = rows[[101, 100]]
    np.savetxt(path, rows, delimiter=",", header=header, comments="")
    return path


def with_nan(folder: Path) -> Path:
    x = 5.0 * np.sin(0.06 * np.arange(300))
    x[117] = np.nan
    return mat(folder / "nan.mat", dist=x)


def truncated(folder: Path) -> Path:
    t = np.arange(2000) * 0.01
    record = Record(t, 0.01 * np.sin(6 * t), 50.0 * np.cos(6 * t), voltage=0.0)
    path = folder / "cut.h5"
    write(record, path)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    return path


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (with_nan, ["117", "finite"]),
        (lambda d: mat(d / "m.mat", forc=None), ["forc"]),
        (lambda d: mat(d / "u.mat", forc=np.zeros(299)), ["299", "300"]),
        (lambda d: csv(d / "back.csv", swap=True), ["1.01", "1"]),
        (lambda d: csv(d / "unit.csv", "time [s],displacement [furlongz],force [N]"), ["furlongz"]),
        (truncated, ["cut.h5"]),
        (lambda d: d / "none.mat", ["no such file"]),
        (lambda d: csv(d / "x.docx"), [".docx", ".csv"]),
    ],
)
def test_a_bad_record(tmp_path: Path, make: Callable[[Path], Path], words: list[str]) -> None:
    path = make(tmp_path)
    line = refused(dampyr("identify", path, "--voltage", "0"))
    assert str(path) in line
    for word in words:
        assert word in line


def card(folder: Path, rho: float = 42745.0) -> Path:
    laws = {
        "dahl.kx": Polynomial((802.0, 493.1), 0.0, 3.212),
        "dahl.kw": Polynomial((50.237, 201.92), 0.0, 3.212),
        "dahl.rho": Polynomial((42745.0, -9000.0), 0.0, 3.212),
    }
    path = Damper("dahl", laws).save(folder / "card.toml")
    path.write_text(path.read_text().replace("42745.0", f"{rho}"))
    return path


def test_an_at2_file_whose_header_lies(tmp_path: Path) -> None:
    path = tmp_path / "lies.AT2"
    rows = "\n".join(" ".join(f"{v: .7E}" for v in np.sin(np.arange(5) + 5 * k)) for k in range(20))
    path.write_text(f"PEER\nsomewhere\nACCELERATION TIME SERIES IN UNITS OF G\nNPTS=   500, DT=   .0100 SEC\n{rows}\n")
    line = refused(dampyr("simulate", card(tmp_path), "--voltage", "1", "--motion", path))
    for word in (str(path), "500", "100"):
        assert word in line


def test_a_voltage_out_of_range(tmp_path: Path) -> None:
    line = refused(dampyr("simulate", card(tmp_path), "--voltage", "5"))
    for word in ("5 V", "0 to 3.212 V", "allow"):
        assert word in line


def test_a_card_whose_rho_is_not_positive(tmp_path: Path) -> None:
    path = card(tmp_path, rho=20000.0)
    line = refused(dampyr("simulate", path, "--voltage", "1"))
    for word in (str(path), "dahl.rho", "-8908", "greater than 0"):
        assert word in line


def test_a_record_without_its_voltage_and_a_wrong_model(tmp_path: Path) -> None:
    path = mat(tmp_path / "ok.mat")
    assert "voltage" in refused(dampyr("identify", path))
    assert "did you mean 'dahl'" in refused(dampyr("identify", path, "--voltage", "0", "--model", "dal"))
    assert "--each" in refused(dampyr("identify", path, "--voltage", "0", "--each", "--save", tmp_path / "c.toml"))
    assert not (tmp_path / "c.toml").exists()


def test_a_process_of_its_own_ends_as_the_command_in_this_process_does(tmp_path: Path) -> None:
    """HDF5, beneath the reader of the truncated file, writes past Python where nobody stops it."""
    for words in (("identify", truncated(tmp_path), "--voltage", "0"), ("simulate", card(tmp_path), "--voltage", "5")):
        assert refused(in_a_process(*words)) == refused(dampyr(*words))
