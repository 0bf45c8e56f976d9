"""Session and specimen: reliable names that records keep, whatever is done to them and wherever they are written."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from tests.records.test_recording import HEADER, block

from dampyr.errors import InputError
from dampyr.records import (
    Record,
    correct_delay,
    cut,
    cycle_average,
    describe,
    nominal_inputs,
    read,
    remove_drift,
    remove_offset,
    with_velocity,
    write,
)
from dampyr.records.files.recording import Recording
from dampyr.records.formats import h5

GROUPS = {"measurement_session": "2026-03-01, no. 7", "specimen": "no. 7 µ"}


def of(record: Record) -> dict[str, str | None]:
    return {name: getattr(record, name) for name in GROUPS}


@pytest.fixture
def record(make_sine: Callable[..., Record]) -> Record:
    return make_sine(voltage=0.5 + 0.001 * np.sin(np.arange(1501)), **GROUPS)


def test_names_are_trimmed_and_may_be_absent(make_sine: Callable[..., Record]) -> None:
    assert of(make_sine()) == {"measurement_session": None, "specimen": None}
    assert make_sine(specimen="  no. 7\t").specimen == "no. 7"


@pytest.mark.parametrize("name", sorted(GROUPS))
@pytest.mark.parametrize(
    ("value", "words"),
    [
        ("", " = '' is not a name; give one line of text that is not empty, or leave it out"),
        (" \n", r" = ' \\n' is not a name"),
        ("a\nb", r" = 'a\\nb' is not a name"),
        (7, " = 7 is not a text; give a name in quotes, or leave it out"),
    ],
)
def test_what_is_no_name_is_refused(make_sine: Callable[..., Record], name: str, value: object, words: str) -> None:
    with pytest.raises(InputError, match=name + words):
        make_sine(**{name: value})


def test_whatever_is_done_to_a_record_keeps_them(record: Record) -> None:
    [nominal] = nominal_inputs([record])
    assert nominal.voltage == 0.5
    done = [
        record.until(8.0), record.thinned(2), with_velocity(record), remove_offset(record), remove_drift(record),
        cycle_average(record), correct_delay(record, 0.01), nominal, *cut(record, 4.0), pickle.loads(pickle.dumps(record)),
        record.replace(note="x", name="other"),
    ]  # fmt: skip
    assert all(of(one) == GROUPS for one in done)


@pytest.mark.parametrize("suffix", ["h5", "csv", "mat", "nc", "parquet"])
def test_every_format_keeps_them(record: Record, tmp_path: Path, suffix: str) -> None:
    path = write(with_velocity(record), tmp_path / f"a.{suffix}")
    assert of(read(path, voltage=0.5 if suffix == "mat" else None)) == GROUPS
    plain = write(with_velocity(record.replace(note="", measurement_session=None, specimen=None)), path)
    assert of(read(plain, voltage=0.5 if suffix == "mat" else None)) == dict.fromkeys(GROUPS)


def test_they_are_attributes_of_the_file_which_older_versions_pass_over(record: Record, tmp_path: Path) -> None:
    with h5py.File(write(record, tmp_path / "a.h5")) as file:
        assert {name: file.attrs[name] for name in GROUPS} == GROUPS
        assert file.attrs["schema"] == 3
    with h5py.File(write(record.replace(note="", measurement_session=None, specimen=None), tmp_path / "b.h5")) as file:
        assert not set(GROUPS) & set(file.attrs)


def test_they_are_shown(record: Record) -> None:
    assert {name: describe(record)[name] for name in GROUPS} == GROUPS
    assert "no. 7 µ" in repr(record)


@pytest.mark.parametrize("finished", [True, False])
def test_a_recording_has_them_from_its_first_moment(tmp_path: Path, finished: bool) -> None:
    recording = Recording(tmp_path / "t.h5", 100, replace(HEADER, **GROUPS))
    recording.append(block(0))
    recording.finish({}) if finished else recording.close()
    assert of(read(tmp_path / "t.h5")) == GROUPS
    assert h5.state(tmp_path / "t.h5").complete is finished
