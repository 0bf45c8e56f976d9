"""TDMS files as npTDMS writes them, after the format that NI publishes."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter

from dampyr.errors import FileError, InputError
from dampyr.records import read, read_campaign

N = 400
TIME = 0.005 * np.arange(N)
STROKE = 8.0 * np.sin(6.0 * TIME)  # mm
FORCE = 300.0 * np.cos(6.0 * TIME) + 20.0  # N


def saved(path: Path, *channels: ChannelObject, group: dict[str, Any] | None = None) -> Path:
    with TdmsWriter(path) as writer:
        writer.write_segment([RootObject({}), GroupObject("Test", group or {}), *channels])
    return path


def channel(name: str, values: Any, unit: str = "", group: str = "Test", **properties: Any) -> ChannelObject:
    return ChannelObject(group, name, np.asarray(values), properties | ({"unit_string": unit} if unit else {}))


def both(**properties: Any) -> list[ChannelObject]:
    return [channel("Displacement", STROKE, "mm", **properties), channel("Force", FORCE / 1e3, "kN", **properties)]


def test_a_waveform_file_is_read_with_its_units_interval_and_properties(tmp_path: Path) -> None:
    path = saved(tmp_path / "run.tdms", *both(wf_increment=0.005), group={"specimen": "damper 3"})
    record = read(path, voltage=0.87)
    np.testing.assert_allclose(record.time, TIME, atol=1e-12)
    np.testing.assert_allclose(record.displacement, 1e-3 * STROKE, rtol=1e-12)
    np.testing.assert_allclose(record.force, FORCE, rtol=1e-12)
    assert (record.voltage, record.specimen, record.provenance["format"]) == (0.87, "damper 3", "TDMS")
    assert any("'Test'" in note for note in record.history)


def test_a_channel_of_time_counts_before_the_interval(tmp_path: Path) -> None:
    path = saved(tmp_path / "run.tdms", channel("Time", 2.0 * TIME, "s"), *both(wf_increment=0.005))
    assert read(path, voltage=0.0).dt == pytest.approx(0.01)


def test_time_stamps_count_from_the_first(tmp_path: Path) -> None:
    stamps = np.datetime64("2026-03-01T23:59:59.5", "us") + (5000 * np.arange(N)).astype("timedelta64[us]")
    record = read(saved(tmp_path / "run.tdms", channel("Time", stamps), *both()), voltage=0.0)
    np.testing.assert_allclose(record.time, TIME, atol=1e-9)
    assert record.provenance["first_sample"].startswith("2026-03-01T23:59:59.5")


def test_names_with_units_and_a_chosen_group(tmp_path: Path) -> None:
    with TdmsWriter(tmp_path / "run.tdms") as writer:
        for name, scale in (("first", 1.0), ("second", 2.0)):
            writer.write_segment(
                [channel("Stroke [mm]", STROKE, group=name), channel("Load (N)", scale * FORCE, group=name)]
            )
    said: dict[str, Any] = {"columns": {"displacement": "Stroke", "force": "Load"}, "dt": "5 ms", "voltage": 0.0}
    with pytest.raises(FileError, match=r"has 2 groups with samples \('first', 'second'\); name one, --variable"):
        read(tmp_path / "run.tdms", **said)
    with pytest.raises(FileError, match="there is no group 'third' with samples; choose from 'first', 'second'"):
        read(tmp_path / "run.tdms", variable="third", **said)
    np.testing.assert_allclose(read(tmp_path / "run.tdms", variable="second", **said).force, 2 * FORCE)


@pytest.mark.parametrize(
    ("channels", "message"),
    [
        (
            lambda: [*both(), channel("Slow", STROKE[::2])],
            r"differ in length \(Displacement 400, Force 400, Slow 200\)",
        ),
        (lambda: both(wf_increment=0.005)[:1] + both(wf_increment=0.01)[1:], "several intervals"),
        (lambda: both(), "no column is the time .*--dt 0.001"),
        (lambda: [channel("Note", np.array(["a"] * N)), *both()], "the channel 'Note' holds .* no numbers"),
        (lambda: [channel("Displacement", STROKE), channel("Force", FORCE, "N")], "'Displacement' has no unit"),
    ],
)
def test_what_cannot_be_a_record_is_said(tmp_path: Path, channels: Any, message: str) -> None:
    said = {} if "time" in message or "interval" in message else {"dt": 0.005}
    with pytest.raises(FileError, match=message):
        read(saved(tmp_path / "run.tdms", *channels()), voltage=0.0, **said)


def test_broken_bytes_are_one_line(tmp_path: Path) -> None:
    path = saved(tmp_path / "run.tdms", *both(wf_increment=0.005))
    for content in (b"", b"TDSm", path.read_bytes()[:50], b"no TDMS at all" * 20):
        path.write_bytes(content)
        with pytest.raises(FileError, match=r"run\.tdms: ") as caught:
            read(path, voltage=0.0)
        assert "\n" not in str(caught.value)


def test_a_folder_of_them_is_a_campaign(tmp_path: Path) -> None:
    for name in ("run 2", "run 10"):
        saved(tmp_path / f"{name}.tdms", *both(wf_increment=0.005))
    assert [each.name for each in read_campaign(tmp_path, voltage=0.0)] == ["run 2", "run 10"]


def test_without_nptdms_the_message_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = saved(tmp_path / "run.tdms", *both(wf_increment=0.005))
    monkeypatch.setitem(__import__("sys").modules, "nptdms", None)
    with pytest.raises(InputError, match=r'TDMS files need npTDMS; install it: pip install "dampyr\[interop\]"'):
        read(path, voltage=0.0)
