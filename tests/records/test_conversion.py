"""Records written in another format, and ``dampyr records convert``."""

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from dampyr.cli import cli
from dampyr.errors import InputError
from dampyr.records import Record, convert, read, read_campaign


@pytest.fixture
def records() -> list[Record]:
    t = 0.004 * np.arange(600)
    x = 0.008 * np.sin(6.0 * t)
    return [
        Record(
            time=t, displacement=x, force=k * 100.0 * np.cos(6.0 * t), voltage=0.5 * k, name=f"run {k}", specimen="A"
        )
        for k in (1, 2)
    ]


@pytest.mark.parametrize("to", ["h5", ".csv", "mat", "nc", "parquet"])
def test_what_comes_back_is_what_was_there(records: list[Record], tmp_path: Path, to: str) -> None:
    seen: list[Path] = []
    paths = convert(records, tmp_path / "new", to, seen.append)
    assert seen == paths == [tmp_path / "new" / f"run {k}.{to.removeprefix('.')}" for k in (1, 2)]
    for before, path in zip(records, paths, strict=True):
        after = read(path) if to != "mat" else read(path, voltage=before.voltage)
        np.testing.assert_allclose(after.force, before.force, rtol=1e-13)
        np.testing.assert_allclose(after.displacement, before.displacement, rtol=1e-13)
        assert (after.voltage, after.specimen) == (before.voltage, "A")


def test_nothing_is_written_where_something_is_wrong(records: list[Record], tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"not written as 'tdms'; choose from csv, h5, mat, nc, parquet"):
        convert(records, tmp_path / "new", "tdms")
    with pytest.raises(InputError, match="2 records are called 'run 1'"):
        convert([records[0], records[0]], tmp_path / "new")
    assert not (tmp_path / "new").exists()
    (tmp_path / "run 2.csv").write_text("mine")
    with pytest.raises(InputError, match=r"run 2\.csv is there already; choose another folder"):
        convert(records, tmp_path, "csv")
    assert [path.name for path in tmp_path.iterdir()] == ["run 2.csv"]


def test_the_command_converts_a_folder(records: list[Record], tmp_path: Path) -> None:
    convert(records, tmp_path / "old", "h5")
    done = CliRunner().invoke(
        cli, ["records", "convert", str(tmp_path / "old"), "--to", "csv", "--out", str(tmp_path / "new"), "--json"]
    )
    assert done.exit_code == 0, done.output
    assert [Path(each).name for each in json.loads(done.stdout)["written"]] == ["run 1.csv", "run 2.csv"]
    assert [each.voltage for each in read_campaign(tmp_path / "new")] == [0.5, 1.0]
    shown = CliRunner().invoke(cli, ["records", str(tmp_path / "new" / "run 1.csv")])
    assert "600" in shown.stdout
    helped = CliRunner().invoke(cli, ["records", "convert", "--help"])
    assert "Usage: dampyr records convert" in helped.stdout or "records convert" in helped.stdout
