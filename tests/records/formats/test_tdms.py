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


START = np.datetime64("2026-03-01T10:00:00", "us")


def sampled(late: float, count: int = N, **more: Any) -> list[ChannelObject]:
    """Two waveforms of one motion; the force's task was started ``late`` s after that of the displacement."""
    times = 0.005 * np.arange(N), late + 0.005 * np.arange(count)
    whole = np.timedelta64(round(late * 1e6) // 1000 * 1000, "us")  # the rest of the time is the offset's
    rest = late - whole / np.timedelta64(1, "s")
    return [
        channel("Displacement", 8.0 * np.sin(6.0 * times[0]), "mm", wf_increment=0.005, wf_start_time=START, **more),
        channel(
            "Force", 300.0 * np.cos(6.0 * times[1]), "N",
            wf_increment=0.005, wf_start_time=START + whole, wf_start_offset=rest, **more,
        ),
    ]  # fmt: skip


@pytest.mark.parametrize(("late", "count"), [(0.010, N), (0.0124, N), (0.010, N - 2), (0.010, N - 9), (-0.5, N)])
def test_waveforms_that_begin_at_different_times_are_brought_to_one_time_base(
    tmp_path: Path, late: float, count: int
) -> None:
    record = read(saved(tmp_path / "run.tdms", *sampled(late, count)), voltage=0.0)
    begin, end = max(0.0, late), min(0.005 * (N - 1), late + 0.005 * (count - 1))
    t = begin + record.time - record.time[0]
    assert record.dt == pytest.approx(0.005)
    assert record.duration == pytest.approx(end - begin, abs=0.005)
    # Straight lines between samples: off by at most (w h)^2 / 8 of the amplitude, 1.1e-4 at 6 rad/s and 5 ms.
    np.testing.assert_allclose(record.displacement, 8e-3 * np.sin(6.0 * t), atol=8e-3 * 1.2e-4)
    np.testing.assert_allclose(record.force, 300.0 * np.cos(6.0 * t), atol=300.0 * 1.2e-4)
    assert any("begin at different times" in line and "interpolated" in line for line in record.history)


def test_an_offset_alone_is_a_start_too(tmp_path: Path) -> None:
    late = [
        channel("Displacement", STROKE, "mm", wf_increment=0.005),
        channel("Force", 300.0 * np.cos(6.0 * (TIME + 0.02)) + 20.0, "N", wf_increment=0.005, wf_start_offset=0.02),
    ]
    with pytest.raises(FileError, match=r"begin at different times .*'Displacement' does not say when it was sampled"):
        read(saved(tmp_path / "a.tdms", late[0], late[1], channel("Other", STROKE, wf_start_offset=0.0)), voltage=0.0)
    late[0] = channel("Displacement", STROKE, "mm", wf_increment=0.005, wf_start_offset=0.0)
    record = read(saved(tmp_path / "b.tdms", *late), voltage=0.0)
    np.testing.assert_allclose(record.displacement, 1e-3 * STROKE[4:], rtol=1e-9)


def test_equal_starts_change_nothing(tmp_path: Path) -> None:
    record = read(saved(tmp_path / "run.tdms", *both(wf_increment=0.005, wf_start_time=START)), voltage=0.0)
    assert np.array_equal(record.displacement, 1e-3 * STROKE)
    assert not any("different times" in line for line in record.history)


def test_waveforms_without_a_common_time_are_refused(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="have no time in common; export channels that were sampled together"):
        read(saved(tmp_path / "run.tdms", *sampled(5.0)), voltage=0.0)


def test_the_energy_of_a_file_with_a_late_force_is_that_of_its_closed_form(tmp_path: Path) -> None:
    """A viscous loop of 1.2 N s/mm on 10 mm at 1 Hz: pi c w A^2; paired by index, 10 ms of phase are in it."""
    n, late, w = 1200, 0.010, 2 * np.pi
    t = 0.005 * np.arange(n)
    x, f = 10.0 * np.sin(w * t), 1.2 * 10.0 * w * np.cos(w * (t + late))
    path = saved(
        tmp_path / "run.tdms",
        channel("Displacement", x, "mm", wf_increment=0.005, wf_start_time=START),
        channel("Force", f, "N", wf_increment=0.005, wf_start_time=START + np.timedelta64(10, "ms")),
    )
    record = read(path, voltage=0.0)
    loop = record.force @ np.gradient(record.displacement)  # J in the whole record
    assert loop / (record.duration * 1.0) == pytest.approx(np.pi * 1200.0 * w * 0.01**2, rel=2e-3)
