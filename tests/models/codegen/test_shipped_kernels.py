"""Kernels that come with a wheel: numba's front end has run before, LLVM optimises on the user's machine."""

import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any

import pytest
from tests.stories.test_newcomer import build_wheel

PROBE = """
import json, sys
from pathlib import Path
import numpy as np
from numba.core.event import Listener, register
from dampyr import compiling
from dampyr.models import Damper
from dampyr.models.codegen import shipped_kernels
from dampyr.structures import respond, single_mass
from dampyr.ground_motions import kanai_tajimi

shipped_kernels.FOLDER, with_building = Path(sys.argv[1]), sys.argv[2] == "True"
fronts, notes = [], []
class Count(Listener):
    def on_start(self, event): fronts.append(event)
    def on_end(self, event): pass
register("numba:run_pass", Count())
damper = Damper("dahl", {"dahl.kx": 100.0, "dahl.kw": 1.0, "dahl.rho": 100.0})
with shipped_kernels.collected_kernels() as found, compiling.watched(notes.append):
    t = np.arange(200) / 100
    answers = [damper.force(t, 0.01 * np.sin(6.0 * t), voltage=0.0, velocity=0.06 * np.cos(6.0 * t))]
    if with_building:
        motion = kanai_tajimi(2.0, 0.01, seed=(1, 1), pga=1.0)
        answers.append(np.asarray(respond(single_mass(2.0e3, stiffness=3.0e5), motion, damper, 0.0).drift))
if found:
    shipped_kernels.write_archive(found)
print(json.dumps([[each.tobytes().hex() for each in answers], len(fronts), sorted(found), notes]))
"""


def run(folder: Path, cache: Path, with_building: bool) -> Any:
    """The numbers, the passes of numba's front end, the entries that were collected, and the notes of compiling."""
    env = os.environ | {"DAMPYR_CACHE": str(cache)}
    words = [sys.executable, "-c", PROBE, str(folder), str(with_building)]
    done = subprocess.run(words, env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize("with_building", [False, pytest.param(True, marks=pytest.mark.prove)])
def test_a_kernel_that_was_shipped_is_finished_without_numbas_front_end_and_gives_the_same_bits(
    with_building: bool, tmp_path: Path
) -> None:
    numbers, fronts, found, notes = run(tmp_path / "kernels", tmp_path / "first", with_building)
    assert fronts > 100
    assert len(found) == 1 + with_building
    assert notes == [True, False] * len(found)
    [archive] = (tmp_path / "kernels").glob("*.zip")
    assert archive.name.startswith(sys.implementation.cache_tag)
    assert sorted(zipfile.ZipFile(archive).namelist()) == found

    # no pass of numba's, nothing that was compiled as a whole
    assert run(tmp_path / "kernels", tmp_path / "second", with_building) == [numbers, 0, found, notes]
    kept = {file.name for file in (tmp_path / "second").glob("kernels-*/*.nb?")}
    assert len(kept) == 2 * len(found)  # an index and machine code of each: the next process finds them there

    archive.unlink()
    assert run(tmp_path / "kernels", tmp_path / "second", with_building) == [numbers, 0, [], []]


def test_an_archive_of_other_sources_is_not_taken(tmp_path: Path) -> None:
    numbers, fronts, found, _ = run(tmp_path / "kernels", tmp_path / "first", False)
    [archive] = (tmp_path / "kernels").glob("*.zip")
    with zipfile.ZipFile(archive) as kept:
        texts = {name: kept.read(name) for name in found}
    folder, key = found[0].rsplit("-", 2)[0], found[0].rsplit("-", 2)[1]
    for old, new in ((folder, "kernels-0123456789abcdef"), (key, "0" * len(key))):  # other compilation; another kernel
        with zipfile.ZipFile(archive, "w") as changed:
            for name, text in texts.items():
                changed.writestr(name.replace(old, new), text)
        assert run(tmp_path / "kernels", tmp_path / new[-8:], False)[:2] == [numbers, fronts]


@pytest.mark.prove
def test_a_wheel_holds_the_archives_that_were_made(tmp_path: Path) -> None:
    archive = "src/dampyr/kernels/cpython-399-some-machine.zip"
    wheel = build_wheel(tmp_path, {archive: b"an archive"})
    with zipfile.ZipFile(wheel) as kept:
        assert kept.read("dampyr/kernels/cpython-399-some-machine.zip") == b"an archive"
    assert wheel.name.endswith(
        "-py3-none-any.whl"
    )  # what it holds is for the machines it names, and no obstacle to others
