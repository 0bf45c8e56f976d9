"""Kernels compiled ahead: afterwards the usual commands compile nothing."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from dampyr import kernel_warming
from dampyr.errors import InputError
from dampyr.models.codegen import kernel_cache

COMMANDS = (
    "simulate raminelli_2020 --voltage 1.98",
    "simulate spencer_1997 --voltage 1.5",
    "simulate raminelli_2020 --control on_off",
    "ensemble raminelli_2020 --voltage 1.98",
)


def dampyr(cache: Path, words: str) -> str:
    env = os.environ | {"DAMPYR_CACHE": str(cache)}
    done = subprocess.run(
        [sys.executable, "-m", "dampyr", *words.split()], env=env, capture_output=True, text=True, check=True
    )
    return done.stdout


def kept(cache: Path) -> list[str]:
    return sorted(file.name for file in cache.glob("kernels-*/*.nb?"))


@pytest.mark.prove
def test_after_warming_the_usual_commands_compile_nothing(tmp_path: Path) -> None:
    first = dampyr(tmp_path, "doctor --warm")
    made = kept(tmp_path)
    assert len(made) > 100  # an index and machine code of each
    assert int(first.split()[0]) == len([name for name in made if name.endswith(".nbi")])
    for words in COMMANDS:
        dampyr(tmp_path, words)
        assert kept(tmp_path) == made, words
    assert "nothing to compile" in dampyr(tmp_path, "doctor --warm")
    next(tmp_path.glob("kernels-*/*.nbi")).unlink()
    assert "compiled 1," in dampyr(tmp_path, "doctor --warm")


def test_work_is_done_once_and_again_when_a_kernel_is_gone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    runs = 0

    def work() -> None:
        nonlocal runs
        runs += 1
        for name in ("one", "two"):
            (tmp_path / f"{name}.nbi").touch()
        raise InputError("an example that cannot be computed")

    monkeypatch.setattr(kernel_cache, "cache_folder", lambda: tmp_path)
    monkeypatch.setattr(kernel_cache, "used_kernels", lambda: {"one.nbi", "two.nbi"})
    monkeypatch.setattr(kernel_warming, "_usual_work", lambda: [("work", work)])
    told: list[tuple[str, float]] = []
    first = kernel_warming.warm_kernels(lambda name, done: told.append((name, done)))
    assert (first.kernels, first.compiled, first.folder, runs) == (2, 2, tmp_path, 1)
    assert told == [("work", 0.0), ("work", 1.0)]
    again = kernel_warming.warm_kernels()
    assert (again.kernels, again.compiled, runs) == (2, 0, 1)
    (tmp_path / "two.nbi").unlink()
    mended = kernel_warming.warm_kernels()
    assert (mended.kernels, mended.compiled, runs) == (2, 1, 2)
    monkeypatch.setattr(kernel_warming, "_sources", lambda: "edited")
    assert kernel_warming.warm_kernels().compiled == 0
    assert runs == 3
    (tmp_path / kernel_warming.DONE).write_text("{half")
    kernel_warming.warm_kernels()
    assert runs == 4
