"""A campaign's folder belongs to one host at a time."""

import errno
import fcntl
import json
import os
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest
from tests.interpreters import run_text

from dampyr.campaigns.folder_lock import NAME, folder_lock
from dampyr.errors import DampyrWarning, FileError, InputError


def test_a_second_host_is_told_who_holds_the_folder(tmp_path: Path) -> None:
    with folder_lock(tmp_path):
        text = json.loads((tmp_path / NAME).read_text())
        words = (
            rf"is used by another campaign: process {os.getpid()} on {text['host']}, since \d{{4}}-.*; wait, or give"
        )
        with pytest.raises(InputError, match=words), folder_lock(tmp_path):
            pass
    assert not list(tmp_path.iterdir())
    with folder_lock(tmp_path):
        pass


HOLDER = textwrap.dedent("""
    import os, sys, time
    from pathlib import Path
    from dampyr.campaigns.folder_lock import folder_lock

    with folder_lock(Path(sys.argv[1])):
        if not os.fork():
            print("held", flush=True)
        time.sleep(60)
""")


def test_what_a_killed_host_left_holds_nobody_off(tmp_path: Path) -> None:
    """Not even where a process that it forked lives on."""
    with subprocess.Popen(
        [sys.executable, "-c", HOLDER, str(tmp_path)], stdout=subprocess.PIPE, text=True, start_new_session=True
    ) as host:
        assert host.stdout is not None
        assert host.stdout.readline() == "held\n"
        try:
            with pytest.raises(InputError, match=f"process {host.pid} on"), folder_lock(tmp_path):
                pass
            host.kill()
            host.wait()
            assert (tmp_path / NAME).is_file()
            with folder_lock(tmp_path):
                pass
        finally:
            os.killpg(host.pid, signal.SIGKILL)


def test_a_lock_without_a_name_holds_too(tmp_path: Path) -> None:
    with folder_lock(tmp_path):
        (tmp_path / NAME).write_text("")
        with pytest.raises(InputError, match="is used by another campaign; wait"), folder_lock(tmp_path):
            pass


@pytest.mark.parametrize("number", [errno.EROFS, errno.ENOSPC])
def test_a_folder_in_which_no_lock_can_be_made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int) -> None:
    def refused(*_: object) -> int:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, "open", refused)
    if number == errno.EROFS:  # nothing is written there
        with folder_lock(tmp_path):
            pass
    else:
        with pytest.raises(FileError, match="cannot be made"), folder_lock(tmp_path):
            pass


@pytest.mark.parametrize("number", [errno.ENOLCK, errno.ENOSYS])
def test_a_file_system_without_locks_is_used_with_a_warning(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    def refused(*_: object) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr("fcntl.flock", refused)
    words = rf"cannot be locked \({os.strerror(number)}\): see to it"
    with pytest.warns(DampyrWarning, match=words) as warned, folder_lock(tmp_path):
        pass
    assert (warned[0].filename, list(tmp_path.iterdir())) == (__file__, [])


def test_a_folder_that_is_gone_is_not_made_again(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="cannot be made"), folder_lock(tmp_path / "gone"):
        pass
    assert not list(tmp_path.iterdir())


def test_a_lock_refused_where_the_file_can_be_written_is_not_passed_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As filelock refuses a file with a second name in a folder that others may write."""

    def refused(*_: object) -> None:
        raise PermissionError(errno.EPERM, "for a reason of its own")

    monkeypatch.setattr("fcntl.flock", refused)
    with pytest.raises(FileError, match="for a reason of its own"), folder_lock(tmp_path):
        pass


def test_the_file_is_removed_while_its_lock_is_held(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    flock, there = fcntl.flock, []

    def watched(descriptor: int, operation: int) -> None:
        if operation == fcntl.LOCK_UN:
            there.append((tmp_path / NAME).exists())
        flock(descriptor, operation)

    monkeypatch.setattr("fcntl.flock", watched)
    with folder_lock(tmp_path):
        pass
    assert there == [False]


def test_a_host_that_has_opened_the_file_before_it_was_removed_locks_the_next_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    flock = fcntl.flock

    def late(descriptor: int, operation: int) -> None:
        monkeypatch.setattr("fcntl.flock", flock)
        (tmp_path / NAME).unlink()
        flock(descriptor, operation)

    monkeypatch.setattr("fcntl.flock", late)
    with folder_lock(tmp_path), pytest.raises(InputError, match=f"process {os.getpid()} on"), folder_lock(tmp_path):
        pass


def test_nor_is_a_removed_file_locked_where_it_keeps_its_inode(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As on NFS, which renames a file that is removed while it is open."""
    flock = fcntl.flock

    def late(descriptor: int, operation: int) -> None:
        if operation != fcntl.LOCK_UN:
            (tmp_path / NAME).rename(tmp_path / ".nfs")
        flock(descriptor, operation)

    monkeypatch.setattr("fcntl.flock", late)
    with pytest.raises(InputError, match="is used by another campaign; wait"), folder_lock(tmp_path):
        pass


UNWOUND = textwrap.dedent("""
    import os, sys
    from pathlib import Path
    from dampyr.campaigns.folder_lock import NAME, folder_lock

    with folder_lock(Path(sys.argv[1])):
        child = os.fork()
        if child:
            status = os.waitpid(child, 0)[1]
            print(status, os.listdir(sys.argv[1]))
""")


def test_a_forked_process_that_ends_first_leaves_the_folder_to_its_host(tmp_path: Path) -> None:
    host = run_text(UNWOUND, ("-c", tmp_path))
    assert (host.stdout, host.stderr) == (f"0 ['{NAME}']\n", "")
    assert not list(tmp_path.iterdir())
