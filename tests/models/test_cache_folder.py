"""The folder of compiled kernels forgets what is old."""

import os
import time
from pathlib import Path

import pytest

from dampyr.models.codegen import kernel_cache


def test_kernels_of_old_sources_go_and_all_else_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    old, young, other = tmp_path / "kernels-0000", tmp_path / "kernels-1111", tmp_path / "notes"
    for folder in (old, young, other):
        folder.mkdir()
        (folder / "file").write_text("x")
    month_ago = time.time() - 31 * 86400
    os.utime(old, (month_ago, month_ago))
    os.utime(other, (month_ago, month_ago))
    monkeypatch.setenv("DAMPYR_CACHE", str(tmp_path))
    kernel_cache.cache_folder.cache_clear()
    try:
        made = kernel_cache.cache_folder()
    finally:
        kernel_cache.cache_folder.cache_clear()
    assert made.parent == tmp_path
    assert made.is_dir()
    assert not old.exists()
    assert young.exists()
    assert other.exists()


def test_once_a_day_kernels_that_nobody_used_for_a_month_go(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DAMPYR_CACHE", str(tmp_path))
    month_ago, day_ago = time.time() - 31 * 86400, time.time() - 2 * 86400
    kernel_cache.cache_folder.cache_clear()
    try:
        folder = kernel_cache.cache_folder()
        old, read, young = (folder / f"{name}.nbc" for name in ("old", "read", "young"))
        for file, times in (
            (old, (month_ago, month_ago)),
            (read, (day_ago, month_ago)),
            (young, (month_ago, day_ago)),
        ):
            file.write_bytes(b"x")
            os.utime(file, times)
        kernel_cache.cache_folder.cache_clear()
        assert kernel_cache.cache_folder() == folder
        assert old.exists()  # it has been looked for today
        os.utime(folder / "swept", (day_ago, day_ago))
        kernel_cache.cache_folder.cache_clear()
        kernel_cache.cache_folder()
    finally:
        kernel_cache.cache_folder.cache_clear()
    assert not old.exists()
    assert read.exists()
    assert young.exists()
