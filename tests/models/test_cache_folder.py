"""The folder of compiled kernels forgets what is old."""

import os
import time
from pathlib import Path

import pytest

from dampyr import source_digest
from dampyr.models.codegen import kernels


def test_kernels_of_old_sources_go_and_all_else_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    old, young, other = tmp_path / "kernels-0000", tmp_path / "kernels-1111", tmp_path / "notes"
    for folder in (old, young, other):
        folder.mkdir()
        (folder / "file").write_text("x")
    month_ago = time.time() - 31 * 86400
    os.utime(old, (month_ago, month_ago))
    os.utime(other, (month_ago, month_ago))
    monkeypatch.setenv("DAMPYR_CACHE", str(tmp_path))
    kernels.cache_folder.cache_clear()
    try:
        made = kernels.cache_folder()
    finally:
        kernels.cache_folder.cache_clear()
    assert made.parent == tmp_path
    assert made.is_dir()
    assert not old.exists()
    assert young.exists()
    assert other.exists()


def test_what_no_kernel_is_made_of_does_not_compile_them_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("models", "report"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "module.py").write_text("a = 1\n")
    monkeypatch.setattr(source_digest, "PACKAGE", tmp_path)
    monkeypatch.setattr(kernels, "KERNEL_SOURCES", ("models", "models/module.py"))

    def digests() -> tuple[str, str]:
        source_digest.source_digest.cache_clear()
        return source_digest.source_digest(kernels.KERNEL_SOURCES), source_digest.source_digest()

    try:
        first = digests()
        (tmp_path / "report" / "module.py").write_text("a = 2\n")
        page = digests()
        (tmp_path / "models" / "module.py").write_text("a = 2\n")
        model = digests()
    finally:
        source_digest.source_digest.cache_clear()
    assert page[0] == first[0]
    assert page[1] != first[1]
    assert model[0] != first[0]


def test_a_cached_kernel_of_another_folder_is_refused() -> None:
    def kernel(x: float) -> float:
        return x

    kernel.__module__ = "dampyr.show.somewhere"
    with pytest.raises(ValueError, match="KERNEL_SOURCES"):
        kernels.jit(kernel, keep=True)
