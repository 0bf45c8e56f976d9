"""A campaign's folder that is gone on with after somebody changed it: nothing is lost, and what differs is told."""

import os
import shutil
import sqlite3
import subprocess
import threading
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest
from tests.campaigns.quick_rig import FIRST, QUAKE, SECOND, TWO_SINES, motion, quick_rig

from dampyr import records
from dampyr.campaigns import campaign, perform
from dampyr.campaigns.journal import Journal
from dampyr.campaigns.run_control import Progress
from dampyr.errors import FileError, InputError
from dampyr.rig import RigSettings


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


def at_the_second_test(act: Callable[[], object]) -> Callable[[Progress], None]:
    done: list[bool] = []

    def show(progress: Progress) -> None:
        if progress.done == 1 and not done:
            done.append(True)
            act()

    return show


def test_a_folder_that_is_moved_while_the_campaign_runs_ends_it_with_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "short.toml").write_text(TWO_SINES)
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
    (tmp_path / "short.toml").write_text(TWO_SINES)
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
