"""What is a finding of a record can be chosen: a threshold that is changed changes what is said."""

from pathlib import Path

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.records import Record, describe, read, read_campaign, with_lowpass, write
from dampyr.records.record import Label
from dampyr.records.record_thresholds import USUAL, RecordThresholds

T = np.arange(0.0, 10.0, 0.005)


def sine(amplitude: float = 0.01, **fields: object) -> Record:
    """Ten cycles of 1 Hz of a damper."""
    x = amplitude * np.sin(2 * np.pi * T)
    force = 500.0 * np.cos(2 * np.pi * T) + 100.0 * np.sign(np.cos(2 * np.pi * T))
    return Record(T, x, force, name="sine", **fields)  # type: ignore[arg-type]


def words(record: Record) -> str:
    """All findings in one text."""
    return " ".join(finding.words for finding in record.findings)


NOISY = 0.01 * np.sin(2 * np.pi * T) + 2e-5 * np.random.default_rng(3).standard_normal(T.size)
SLIPPED = 0.01 * np.sin(2 * np.pi * T) + 0.004 * (T > 5.1)
SPIKED = 0.01 * np.sin(2 * np.pi * T) + 0.006 * (np.arange(T.size) == 777)


@pytest.mark.parametrize(
    ("record", "said", "changed"),
    [
        (sine(3.0), "is its unit right", {"unlikely_stroke": "7 m"}),
        (sine().thinned(10), "samples per cycle", {"samples_per_cycle": 10}),
        (sine(label=Label(0.02, 1.1)), "labelled 1.1 Hz", {"label_frequency": 0.2}),
        (sine(label=Label(0.025, 1.0)), "labelled 25 mm", {"label_peak_to_peak": 0.4}),
        (sine().replace(note="noise", displacement=NOISY), "turns the direction of motion", {"uncertain_direction": 0.9}),
        (sine().replace(note="slip", displacement=SLIPPED), "leaps 1 time within one sample", {"leap": 100.0}),
        (sine().replace(note="spike", displacement=SPIKED), "1 false sample", {"false_sample": 1.0}),
    ],
)  # fmt: skip
def test_a_changed_threshold_changes_what_is_said(record: Record, said: str, changed: dict[str, object]) -> None:
    assert said in words(record)
    other = record.replace(note="thresholds", thresholds=RecordThresholds(**changed))  # type: ignore[arg-type]
    assert said not in words(other)
    assert words(other.replace(note="back", thresholds=USUAL)) == words(record)


def test_a_narrower_threshold_finds_more() -> None:
    assert words(sine()) == ""
    assert "is its unit right" in words(sine(thresholds=RecordThresholds(unlikely_stroke=0.01)))
    jittered = sine(thresholds=RecordThresholds(jitter=0.0)).replace(note="clock", time=T + 1e-6 * np.sin(T))
    assert "sampling jitter" in words(jittered)


def test_they_come_with_the_call_that_reads_and_stay_with_the_record(tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    path = write(sine(3.0), folder / "sine.csv")
    assert "is its unit right" in words(read(path))
    wide = RecordThresholds(unlikely_stroke=10.0)
    for record in (read(path, thresholds=wide), *read_campaign(folder, thresholds=wide)):
        assert record.thresholds == wide
        assert "is its unit right" not in words(record)
        assert "is its unit right" not in str(describe(record)["findings"])
        assert with_lowpass(record, 20.0).thresholds == wide


def test_a_wrong_value_is_refused_with_its_range() -> None:
    with pytest.raises(InputError, match=r"gap = 0\.5 is not allowed; it must be greater than 1"):
        RecordThresholds(gap=0.5)
    with pytest.raises(InputError, match="unlikely_stroke"):
        RecordThresholds(unlikely_stroke="2 s")  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"thresholds = 3 are not allowed; give RecordThresholds"):
        read("any.csv", thresholds=3)
