"""A campaign's folder that is gone on with after somebody changed it: nothing is lost, and what differs is told."""

import json
import os
import shutil
import sqlite3
import subprocess
import threading
from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from tests.campaigns.quick_rig import QUICK, quick_rig

from dampyr import records
from dampyr.campaigns import campaign, perform, read_journal
from dampyr.campaigns.journal import Journal
from dampyr.campaigns.run_control import Progress
from dampyr.campaigns.run_folders import run_folder
from dampyr.errors import DampyrWarning, FileError, InputError
from dampyr.records.formats import h5
from dampyr.rig import RigSettings, simulated

SHORT = """
name = "short"
rest_between = "0.1 s"
check_amplitude = "0 mm"
[[step]]
kind = "sine"
amplitude = "4 mm"
frequency = "1 Hz"
voltage = ["0 V", "1 V"]
cycles = 1
rest_before = "0.2 s"
"""
FIRST, SECOND = "01-sine-4mm-1Hz-0V", "02-sine-4mm-1Hz-1V"


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recorded")
    (folder / "short.toml").write_text(SHORT)
    perform(folder / "short.toml", quick_rig(), folder / "out")
    return folder


@pytest.fixture
def lab(recorded: Path, tmp_path: Path) -> Path:
    shutil.copytree(recorded, tmp_path / "lab")
    return tmp_path / "lab"


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.glob("*.h5*")}


def set_running(out: Path, name: str) -> None:
    """As a killed host leaves the journal."""
    with closing(sqlite3.connect(out / "journal.sqlite")) as base:
        base.execute("UPDATE tests SET state = 'running' WHERE name = ?", (name,))
        base.commit()


def test_a_second_host_is_refused(lab: Path) -> None:
    errors: list[BaseException] = []

    def second(progress: Progress) -> None:
        if progress.phase == "testing" and not errors:
            try:
                perform(lab / "short.toml", quick_rig(), lab / "out")
            except InputError as problem:
                errors.append(problem)

    perform(lab / "short.toml", quick_rig(), lab / "out", again=[SECOND], progress=second)
    assert f"is used by another campaign: process {os.getpid()} on" in str(errors[0])
    assert len(list((lab / "out").glob("*.h5"))) == 3


@pytest.mark.parametrize("how", ["gone", "broken"])
def test_a_complete_file_that_cannot_be_read_is_told_and_recorded_again_when_asked(lab: Path, how: str) -> None:
    out, path = lab / "out", lab / "out" / f"{FIRST}.h5"
    if how == "gone":
        path.unlink()
    else:
        path.write_bytes(path.read_bytes()[:3000])
    words = rf"cannot be read: {FIRST} \({how}\); run the same command with --again {FIRST} to record them again"
    opened = quick_rig()
    with pytest.raises(FileError, match=f"out: 1 of 2 tests are complete: files of complete tests {words}"):
        perform(lab / "short.toml", opened, out)
    assert opened.board.simulator.time == 0.0
    about = run_folder(out)
    assert (about.state, about.complete, about.tests) == ("interrupted", 1, 2)
    assert f"{FIRST} ({how})" in about.reason
    perform(lab / "short.toml", quick_rig(), out, again=[FIRST])
    assert {record.name for record in records.read_campaign(out)} == {FIRST, SECOND}
    assert h5.state(out / f"{FIRST}.try2.h5").complete
    assert (out / f"{FIRST}.h5.broken").is_file() == (how == "broken")
    assert [event.what for event in read_journal(out)[1]].count("again") == 1
    perform(lab / "short.toml", quick_rig(), out)  # nothing is missed any more
    assert run_folder(out).complete == 2


def test_what_is_left_is_run_before_a_lost_file_is_an_error(lab: Path) -> None:
    (lab / "out" / f"{FIRST}.h5").unlink()
    with closing(Journal(lab / "out")) as journal:
        journal.repeat(SECOND)
    with (
        pytest.warns(DampyrWarning, match=rf"{FIRST} \(gone\)"),
        pytest.raises(FileError, match=rf"1 of 2 tests are complete.*{FIRST} \(gone\)"),
    ):
        perform(lab / "short.toml", quick_rig(), lab / "out")
    assert h5.state(lab / "out" / f"{SECOND}.try2.h5").complete


def test_a_file_with_a_damaged_dataset_is_recorded_again_when_asked(lab: Path) -> None:
    with h5py.File(lab / "out" / f"{FIRST}.h5", "r+") as file:
        file["calibrated/force"][100] += 1.0
    with pytest.raises(FileError, match=r"/calibrated/force is not what was written.*dampyr run has --again for it"):
        records.read_campaign(lab / "out")
    perform(lab / "short.toml", quick_rig(), lab / "out", again=[FIRST])
    assert len(records.read_campaign(lab / "out", incomplete=True)) == 2
    assert (lab / "out" / f"{FIRST}.h5.broken").is_file()


def test_a_whole_file_is_recorded_again_beside_itself(lab: Path) -> None:
    before = contents(lab / "out")
    perform(lab / "short.toml", quick_rig(), lab / "out", again=[SECOND])
    after = contents(lab / "out")
    assert {name: after[name] for name in before} == before
    assert set(after) - set(before) == {f"{SECOND}.try2.h5"}
    with pytest.raises(
        InputError, match=f"again = 'third' is not a test of this campaign; its tests are {FIRST}, {SECOND}"
    ):
        perform(lab / "short.toml", quick_rig(), lab / "out", again=["third"])


def test_a_truncated_file_of_an_interrupted_test_does_not_stop_the_campaign(lab: Path) -> None:
    path = lab / "out" / f"{SECOND}.h5"
    path.write_bytes(path.read_bytes()[:2000])
    set_running(lab / "out", SECOND)
    perform(lab / "short.toml", quick_rig(), lab / "out")
    assert (lab / "out" / f"{SECOND}.h5.broken").read_bytes() == path.with_name(f"{SECOND}.h5.broken").read_bytes()
    assert len(records.read_campaign(lab / "out", incomplete=True)) == 2
    assert any("its file cannot be read" in event.detail for event in read_journal(lab / "out")[1])


def test_a_lost_journal_and_a_broken_file_have_a_way_out(lab: Path) -> None:
    out = lab / "out"
    (out / "journal.sqlite").unlink()
    (out / f"{FIRST}.h5").write_bytes(b"")
    with pytest.raises(FileError, match=f"record it again with --again {FIRST}, or give another --out"):
        perform(lab / "short.toml", quick_rig(), out)
    with pytest.warns(DampyrWarning, match="from the files of 1 of its 2 tests: 1 complete"):
        perform(lab / "short.toml", quick_rig(), out, again=[FIRST])
    assert len(records.read_campaign(out)) == 2
    assert h5.state(out / f"{FIRST}.try2.h5").complete


def test_parts_of_copies_go_away_whatever_the_journal_says(lab: Path) -> None:
    out = lab / "out"
    for name in (f".{FIRST}.h5.abcd_123.part", f".{SECOND}.try3.h5.abcd1234.part", ".other.h5.abcd1234.part"):
        (out / name).write_bytes(b"half")
    (out / "journal.sqlite").unlink()
    with pytest.warns(DampyrWarning, match="made anew"):
        perform(lab / "short.toml", quick_rig(), out)
    assert [path.name for path in out.glob(".*")] == [".other.h5.abcd1234.part"]


def shortened(path: Path, rows: int) -> None:
    """As a host leaves it that is killed after so many samples."""
    with h5py.File(path, "r+") as file:
        file.attrs["complete"] = np.uint8(0)
        file["rows"] = np.uint64(rows)
        del file.attrs["sha256"]


@pytest.mark.parametrize("rows", [0, 1, 7])
def test_a_try_with_few_samples_does_not_break_its_folder(lab: Path, rows: int) -> None:
    shortened(lab / "out" / f"{SECOND}.h5", rows)
    set_running(lab / "out", SECOND)
    words = rf"left out, too few samples for a record: {SECOND}.h5 \({rows}\)"
    with pytest.warns(DampyrWarning, match=words):
        assert len(records.read_campaign(lab / "out", incomplete=True)) == 1
    perform(lab / "short.toml", quick_rig(), lab / "out")
    assert len(records.read_campaign(lab / "out")) == 2
    with pytest.warns(DampyrWarning, match=words):
        assert len(records.read_campaign(lab / "out", incomplete=True)) == 2


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("cycles = 1", "cycles = 2"), f"{FIRST}: cycles was 1, is 2; {SECOND}: cycles was 1, is 2"),
        (('rest_before = "0.2 s"', 'rest_before = "0.3 s"'), f"{FIRST}: rest_before was 0.2 s, is 0.3 s"),
        (('"0 V", "1 V"', '"0 V"'), "02-sine-4mm-1Hz-1V is not in it any more"),
        (('"0 V", "1 V"', '"1 V", "0 V"'), "is not in it any more; .* is new in it"),
        (('rest_between = "0.1 s"', 'rest_between = "0.1 s"\nseed = 3\norder = "random"'), "another order"),
    ],
)
def test_another_campaign_is_told_what_differs(lab: Path, change: tuple[str, str], words: str) -> None:
    (lab / "short.toml").write_text(SHORT.replace(*change))
    with pytest.raises(InputError, match=rf"holds the campaign 'short', and this one differs: .*{words}"):
        perform(lab / "short.toml", quick_rig(), lab / "out")
    (lab / "out/journal.sqlite").unlink()
    with pytest.raises(FileError, match="is not of the campaign 'short'"):
        perform(lab / "short.toml", quick_rig(), lab / "out")


QUAKE = (
    SHORT.split("[[step]]")[0]
    + '[[step]]\nkind = "earthquake"\nmotion = "motion.csv"\nscale = 0.02\nrest_before = "0.2 s"\n'
)


def motion(path: Path, size: float) -> None:
    t = np.arange(0.0, 1.0, 0.02)
    rows = "".join(f"{at:.2f},{size * np.sin(4 * np.pi * at):.6f}\n" for at in t)
    path.write_text(f"time [s],acceleration [m/s^2]\n{rows}")


def test_a_campaign_with_its_motion_goes_on_where_it_was_moved_to_and_not_with_another_motion(tmp_path: Path) -> None:
    old, new = tmp_path / "old", tmp_path / "new"
    old.mkdir()
    (old / "quake.toml").write_text(QUAKE)
    motion(old / "motion.csv", 1.0)
    perform(old / "quake.toml", quick_rig(), old / "out")
    old.rename(new)
    opened = quick_rig()
    perform(new / "quake.toml", opened, new / "out")
    assert opened.board.simulator.time == 0.0
    shutil.copy(new / "out/journal.sqlite", tmp_path)
    (new / "out/journal.sqlite").unlink()
    with pytest.warns(DampyrWarning, match="1 complete, 0 not"):
        perform(new / "quake.toml", quick_rig(), new / "out")
    motion(new / "motion.csv", 1.5)
    with pytest.raises(
        InputError, match=r"this one differs: 01-earthquake.*: the file of its motion holds something else"
    ):
        perform(new / "quake.toml", quick_rig(), new / "out")
    (new / "out/journal.sqlite").unlink()
    with pytest.raises(FileError, match="what is in its files differ"):
        perform(new / "quake.toml", quick_rig(), new / "out")


def test_a_journal_with_the_digest_of_paths_is_gone_on_with(tmp_path: Path) -> None:
    (tmp_path / "quake.toml").write_text(QUAKE)
    motion(tmp_path / "motion.csv", 1.0)
    perform(tmp_path / "quake.toml", quick_rig(), tmp_path / "out")
    read = campaign.read(tmp_path / "quake.toml")
    assert read.path_digest != read.digest
    with closing(Journal(tmp_path / "out")) as journal:
        journal.set_metadata({"digest": read.path_digest, "contents": ""})
    perform(tmp_path / "quake.toml", quick_rig(), tmp_path / "out")
    with closing(Journal(tmp_path / "out")) as journal:
        assert journal.get_metadata("digest") == read.digest


def test_the_motion_of_a_changed_file_is_read_anew(tmp_path: Path) -> None:
    peaks = []
    for size in (1.0, 1.5):
        motion(tmp_path / "motion.csv", size)
        (tmp_path / "quake.toml").write_text(QUAKE)
        step = campaign.read(tmp_path / "quake.toml").tests[0].step
        peaks.append(step.peaks(RigSettings()).position)
    assert peaks[1] == pytest.approx(1.5 * peaks[0], rel=1e-6)


def test_settings_that_were_changed_are_told_and_kept_with_each_record(lab: Path) -> None:
    changed = replace(
        QUICK,
        load_cell=replace(QUICK.load_cell, scale=700.0),
        encoder=replace(QUICK.encoder, count=1e-5),
    )
    words = r"encoder\.count was 0\.005 mm, is 0\.01 mm; load_cell\.scale was 613 N/V, is 700 N/V"
    opened = simulated(changed)
    perform(lab / "short.toml", opened, lab / "out")  # nothing is left: nothing is told
    with pytest.warns(DampyrWarning, match=f"settings differ from those that the campaign was begun with: {words}"):
        perform(lab / "short.toml", opened, lab / "out", again=[SECOND])
    first, second = records.read_campaign(lab / "out")
    assert "rig_changes" not in first.provenance
    assert second.provenance["rig_changes"].startswith("encoder.count was 0.005 mm")
    assert [event.what for event in read_journal(lab / "out")[1]].count("settings changed") == 1
    (lab / "out/journal.sqlite").unlink()  # the first record's settings are those that it was begun with
    with pytest.warns(DampyrWarning, match="made anew"), pytest.warns(DampyrWarning, match=words):
        perform(lab / "short.toml", simulated(changed), lab / "out", again=[FIRST])
    with closing(Journal(lab / "out")) as journal:
        assert json.loads(journal.get_metadata("rig"))["load_cell"]["scale"] == 613.0


def at_the_second_test(act: Callable[[], object]) -> Callable[[Progress], None]:
    done: list[bool] = []

    def show(progress: Progress) -> None:
        if progress.done == 1 and not done:
            done.append(True)
            act()

    return show


def test_a_folder_that_is_moved_while_the_campaign_runs_ends_it_with_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "short.toml").write_text(SHORT)
    opened = quick_rig()
    show = at_the_second_test(lambda: (tmp_path / "out").rename(tmp_path / "elsewhere"))
    with pytest.raises(
        FileError, match="its folder was moved or deleted; move it back, or give its new place"
    ) as caught:
        perform(tmp_path / "short.toml", opened, tmp_path / "out", show)
    assert "\n" not in str(caught.value)
    assert not opened.board.simulator.twin.enabled
    perform(tmp_path / "short.toml", quick_rig(), tmp_path / "elsewhere")
    assert len(records.read_campaign(tmp_path / "elsewhere")) == 2


def test_a_journal_that_is_locked_while_the_campaign_runs_ends_it_with_a_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    connect = sqlite3.connect
    monkeypatch.setattr(sqlite3, "connect", lambda path, **how: connect(path, timeout=0.1, **how))
    (tmp_path / "short.toml").write_text(SHORT)
    opened = quick_rig()
    with closing(connect(tmp_path / "other.sqlite")) as other:

        def lock() -> None:
            other.execute("ATTACH ? AS journal", (str(tmp_path / "out/journal.sqlite"),))
            other.execute("BEGIN EXCLUSIVE")

        with pytest.raises(
            FileError, match=r"is locked by another program.*; close that program, and run the campaign"
        ):
            perform(tmp_path / "short.toml", opened, tmp_path / "out", at_the_second_test(lock))
        assert not opened.board.simulator.twin.enabled
        with pytest.raises(FileError, match="is locked by another program"):
            perform(tmp_path / "short.toml", quick_rig(), tmp_path / "out")
    perform(tmp_path / "short.toml", quick_rig(), tmp_path / "out")
    assert len(records.read_campaign(tmp_path / "out")) == 2


def test_a_folder_that_is_read_only_is_called_so(lab: Path, tmp_path: Path) -> None:
    disk = tmp_path / "disk"
    disk.mkdir()
    mount = ["mount", "-t", "tmpfs", "tmpfs", str(disk)]
    if os.geteuid() or subprocess.run(mount, check=False, capture_output=True).returncode:
        pytest.skip("only root may mount a disk")
    try:
        shutil.copytree(lab / "out", disk / "out")
        (disk / "empty").mkdir()
        subprocess.run(["mount", "-o", "remount,ro", str(disk)], check=True)
        perform(lab / "short.toml", quick_rig(), disk / "out")  # complete
        for folder, again in ((disk / "out", [FIRST]), (disk / "empty", [])):
            with pytest.raises(FileError, match="as if it or its folder were read-only"):
                perform(lab / "short.toml", quick_rig(), folder, again=again)
    finally:
        subprocess.run(["umount", str(disk)], check=True)


def test_two_threads_of_a_process_are_two_hosts(lab: Path) -> None:
    begun, errors = threading.Event(), []

    def show(_: Progress) -> None:
        begun.set()

    runs = threading.Thread(
        target=perform, args=(lab / "short.toml", quick_rig(), lab / "out", show), kwargs={"again": [FIRST]}
    )
    runs.start()
    assert begun.wait(20)
    try:
        perform(lab / "short.toml", quick_rig(), lab / "out")
    except InputError as problem:
        errors.append(str(problem))
    runs.join()
    assert "is used by another campaign" in errors[0]
