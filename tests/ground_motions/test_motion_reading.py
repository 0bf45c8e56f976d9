"""``reading.toml`` beside ground motions, and the encoding and the delimiter of a text."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from dampyr.cli import cli
from dampyr.errors import FileError, InputError
from dampyr.ground_motions import read, read_folder

A = np.round(0.3 * np.sin(0.1 * np.arange(200)), 6)
TOML = """
voltage = 1.0

[motions]
units = { acceleration = "g" }

[[motions.files]]
pattern = "plain.*"
dt = 0.02

[[motions.files]]
pattern = "logger*"
columns = { time = "時計", acceleration = "加速" }
units = { time = "ms", acceleration = "gal" }
encoding = "shift_jis"
delimiter = "|"
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "reading.toml").write_text(TOML, encoding="utf-8")
    np.savetxt(tmp_path / "plain.txt", A)
    rows = "".join(f"{10 * k}|{100 * a:.6f}\n" for k, a in enumerate(A))
    (tmp_path / "logger 1.csv").write_bytes(f"時計|加速\n{rows}".encode("shift_jis"))
    return tmp_path


def test_what_the_files_do_not_state_is_taken_from_it(folder: Path) -> None:
    plain, logger = read(folder / "plain.txt"), read(folder / "logger 1.csv")
    np.testing.assert_allclose(plain.acceleration, 9.80665 * A, rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(logger.acceleration, A, rtol=1e-9, atol=1e-9)
    assert (plain.dt, logger.dt, logger.history) == (0.02, 0.01, ("read as shift_jis text, as declared",))
    entries = read_folder(folder).entries
    assert [(entry.file, entry.problem) for entry in entries] == [("logger 1.csv", ""), ("plain.txt", "")]
    assert entries[1].motion is not None
    assert entries[1].motion.dt == 0.02
    shown = CliRunner().invoke(cli, ["motion", str(folder / "plain.txt")])
    assert "every 0.02 s" in shown.output or "every 20 ms" in shown.output


def test_a_call_goes_before_it(folder: Path) -> None:
    motion = read(folder / "plain.txt", units="m/s^2", dt=0.005)
    assert motion.dt == 0.005
    np.testing.assert_allclose(motion.acceleration, A)
    with pytest.raises(FileError, match="is not utf-8 text"):
        read(folder / "logger 1.csv", encoding="utf-8")
    with pytest.raises(FileError, match="holds no numbers"):
        read(folder / "logger 1.csv", delimiter=";")
    words = ["motion", str(folder / "logger 1.csv"), "--delimiter", "bar"]
    assert "delimiter = 'bar' does not part columns; choose from" in CliRunner().invoke(cli, words).output
    with pytest.raises(InputError, match="encoding = 'kana' is not known; choose one such as utf-8"):
        read(folder / "plain.txt", encoding="kana")


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("[motions]\nunit = 'g'", r"\[motions\] 'unit' is not known; choose from units, columns"),
        ("[motions]\ndt = 0", r"\[motions\] dt = 0 is not allowed; it must be a number greater than 0"),
        ("motions = 1", r"motions = 1 is not a table; write what it says below \[motions\]"),
        ("[motions]\nunits = {force = 'N'}", "names 'force', which is not a channel; choose from time, acceleration"),
        ("[[motions.files]]\ndt = 0.1", r"\[\[motions.files\]\] 1: pattern = None is not a pattern"),
        (
            "[[motions.files]]\npattern='p*'\ndt=0.1\n[[motions.files]]\npattern='*n'\ndt=0.2",
            "2: '\\*n' and a pattern above give plain.txt two values of dt; make them exclusive",
        ),
    ],
)
def test_what_is_wrong_in_it_is_said(folder: Path, text: str, match: str) -> None:
    (folder / "reading.toml").write_text(text)
    with pytest.raises(FileError, match=rf"reading\.toml: .*{match}"):
        read(folder / "plain.txt")
