"""Uncertainty of a record's channels: in the record, in its file, in tables and on pages."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from click.testing import CliRunner

from dampyr import records
from dampyr.cli import cli
from dampyr.errors import FileError, InputError
from dampyr.records import Record
from dampyr.records.checks.channel_uncertainty import ChannelUncertainty
from dampyr.records.files.checksums import NAME
from dampyr.show.pages.uncertainty_section import uncertainty_section

TIME = np.arange(4000) / 1000.0
STATED = {
    "force": ChannelUncertainty({"scale": 3.0, "zero": 4.0}),
    "displacement": ChannelUncertainty({"resolution of the encoder": 2e-6}),
    "voltage": ChannelUncertainty({"gain of the supply": 0.02}),
}


def record(**about: object) -> Record:
    x = 0.005 * np.sin(2.0 * np.pi * TIME)
    force = 100.0 * np.tanh(np.gradient(x, TIME) / 0.003)
    return Record(TIME, x, force, voltage=1.5, name="one", **about)  # type: ignore[arg-type]


def test_parts_are_added_in_squares() -> None:
    assert STATED["force"].standard == 5.0
    assert STATED["force"].largest == "zero"
    assert ChannelUncertainty({}).standard == 0.0
    for wrong in (-1.0, np.nan, np.inf):
        with pytest.raises(InputError, match="uncertainty scale"):
            ChannelUncertainty({"scale": wrong})


def test_a_record_keeps_it_through_files_copies_and_cuts(tmp_path: Path) -> None:
    one = record(uncertainty=STATED)
    read = records.read(records.write(one, tmp_path / "one.h5"))
    assert dict(read.uncertainty) == STATED
    assert dict(pickle.loads(pickle.dumps(read)).uncertainty) == STATED
    assert dict(read.until(2.0).uncertainty) == STATED
    with h5py.File(tmp_path / "one.h5") as file:
        assert file["calibrated/force"].attrs["uncertainty"] == 5.0
    assert dict(records.read(records.write(record(), tmp_path / "two.h5")).uncertainty) == {}


def test_of_no_channel_is_refused() -> None:
    with pytest.raises(InputError, match="uncertainty of 'load' is of no channel; choose from time, displacement"):
        record(uncertainty={"load": STATED["force"]})


def test_a_file_in_other_units_and_a_damaged_one(tmp_path: Path) -> None:
    path = records.write(record(uncertainty=STATED), tmp_path / "one.h5")
    with h5py.File(path, "r+") as file:
        del file.attrs[NAME]
        file["calibrated/force"].attrs["unit"] = "kN"
        file["calibrated/force"][...] = file["calibrated/force"][()] / 1000.0
    assert records.read(path).uncertainty["force"].standard == pytest.approx(5000.0)
    with h5py.File(path, "r+") as file:
        file["calibrated/force"].attrs["uncertainty_parts"] = "[1"
    with pytest.raises(FileError, match="states no uncertainty that can be read"):
        records.read(path)


def test_it_is_shown_of_one_record_and_given_to_machines(tmp_path: Path) -> None:
    path = str(records.write(record(uncertainty=STATED), tmp_path / "one.h5"))
    shown = CliRunner().invoke(cli, ["records", path])
    assert "force uncertainty" in shown.output
    assert "5 N (one sigma), by zero before all" in shown.output
    assert records.describe(records.read(path))["uncertainty"]["force"]["parts"] == {"scale": 3.0, "zero": 4.0}
    assert "force 5 N, displacement 2 µm (one sigma)" in repr(records.read(path))


def test_the_page_of_a_fit_has_a_table_of_it() -> None:
    section = uncertainty_section([record(uncertainty=STATED), record(), record(uncertainty=scaled(3.0))])
    assert section is not None
    text, table = section.blocks
    rows = {row[0]: row for row in table.rows}
    assert rows["force"][1:6] == ["N", 10.0, 5.0, 15.0, "zero"]
    assert rows["displacement"][2] == pytest.approx(4.0)  # µm
    assert "1 of 3 records state none" in text.text
    assert uncertainty_section([record()]) is None


def scaled(factor: float) -> dict[str, ChannelUncertainty]:
    return {
        name: replace(one, parts={part: factor * value for part, value in one.parts.items()})
        for name, one in STATED.items()
    }
