"""A campaign's folder belongs to one host at a time."""

import errno
import json
import os
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

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


def test_a_file_system_without_locks_is_used_with_a_warning(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: object) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr("dampyr.campaigns.folder_lock._lock", refused)
    with pytest.warns(DampyrWarning, match="cannot be locked"), folder_lock(tmp_path):
        pass
