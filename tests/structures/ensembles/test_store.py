"""The file of an ensemble: what it shows lies in it."""

import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from mmap import mmap
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from dampyr.errors import FileError
from dampyr.ground_motions import GroundMotion, el_centro
from dampyr.models import Damper
from dampyr.structures import ensemble, read_ensemble, two_storey
from dampyr.structures.ensembles import job_array, store
from dampyr.structures.ensembles.store import progress_of


@pytest.mark.parametrize("read", [read_ensemble, store.progress_of, job_array._opened])
@pytest.mark.parametrize("name", ["done", "drift", "labels"])
def test_what_points_out_of_a_file_is_refused(tmp_path: Path, read: Callable[[Path], Any], name: str) -> None:
    (tmp_path / "secret.bin").write_bytes(np.full(10, 777.25).tobytes())
    path = tmp_path / "part-1-of-2.h5"
    with h5py.File(path, "w") as file:
        file.attrs.update({"format": store.FORMAT, "part": 1, "quantities": ["drift"]})
        if name != "done":
            file["done"] = np.ones(1, bool)
        file.create_dataset(name, (10,), "f8", external=[(str(tmp_path / "secret.bin"), 0, 80)])
    with pytest.raises(FileError, match=f"/{name} has its values in another file"):
        read(path)


pytestmark = pytest.mark.filterwarnings("ignore:.*was calibrated:dampyr.errors.DampyrWarning")


def test_a_killed_run_goes_on(cubics: Damper, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dampyr.structures.ensembles.ensemble_grid.CASES_PER_SHARD", 8)
    given = (two_storey(), el_centro(), cubics, [0.0, 0.5, 1.0, 1.5], np.linspace(0.5, 2.0, 8))
    calls: list[tuple[int, int]] = []

    def killed(done: int, size: int) -> None:
        calls.append((done, size))
        if len(calls) == 2:
            raise KeyboardInterrupt

    with ThreadPoolExecutor(1) as pool:
        with pytest.raises(KeyboardInterrupt):
            ensemble(*given, pool, out=tmp_path / "e.h5", progress=killed)
        assert calls == [(8, 32), (16, 32)]
        again: list[tuple[int, int]] = []
        monkeypatch.setattr(
            "dampyr.structures.ensembles.ensemble_grid.CASES_PER_SHARD", 16
        )  # the file goes on as it was begun
        dataset = ensemble(*given, pool, out=tmp_path / "e.h5", progress=lambda *now: again.append(now)).dataset
    assert again == [(24, 32), (32, 32)]
    monkeypatch.setattr(
        "dampyr.structures.ensembles.ensemble_grid.CASES_PER_SHARD", 8
    )  # the error is measured in every shard
    assert dataset.identical(ensemble(*given).dataset)
    with pytest.raises(FileError, match="holds another ensemble"):
        ensemble(*given[:3], [0.0], out=tmp_path / "e.h5")


RUN = """
import sys
from concurrent.futures import ThreadPoolExecutor
import numpy as np
from dampyr.ground_motions import kanai_tajimi
from dampyr.structures import ensemble, two_storey
from dampyr.structures.ensembles import ensemble_grid
ensemble_grid.CASES_PER_SHARD = 16
print("ready", flush=True)
found = ensemble(
    two_storey(), [kanai_tajimi(9.0, 0.02, seed=k, pga=3.0) for k in range(300)], scales=np.linspace(0.1, 2.0, 16),
    executor=ThreadPoolExecutor(1), out=sys.argv[1], progress=lambda done, size: print(done, flush=True),
)
print(found.drift.sum().item(), found.attrs["error_estimate"])
"""


@pytest.mark.prove
def test_a_run_that_is_killed_again_and_again_ends_like_any_other(tmp_path: Path) -> None:
    """Kills 0 to 20 ms after the file is begun or a shard is told: while files are made, values written, shards marked."""
    expected = subprocess.run([sys.executable, "-c", RUN, str(tmp_path / "whole.h5")], capture_output=True, text=True)
    path, rng, before = tmp_path / "e.h5", np.random.default_rng(3), 0
    for k in range(5):
        with subprocess.Popen([sys.executable, "-c", RUN, str(path)], stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout.readline() == "ready\n"
            first = int(process.stdout.readline()) if k >= 3 else 0  # the file is there
            time.sleep(rng.uniform(0.0, 0.02))
            process.kill()
        assert first >= before, "what was there is done again"
        before = max(first, before)
    done, shards = progress_of(path)
    assert 0 < done < shards
    ended = subprocess.run([sys.executable, "-c", RUN, str(path)], capture_output=True, text=True)
    assert ended.stdout.splitlines()[-1] == expected.stdout.splitlines()[-1] != "", ended.stderr
    assert not list(tmp_path.glob(".*.part"))


def test_large_results_stay_in_their_file(
    cubics: Damper, motions: list[GroundMotion], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given = (two_storey(), motions, [cubics, None], [0.0, 1.0], [0.5, 2.0])
    small = ensemble(*given, out=tmp_path / "small.h5").dataset
    monkeypatch.setattr("dampyr.structures.ensembles.store.MAPPED", 0)
    large, again = ensemble(*given, out=tmp_path / "large.h5").dataset, read_ensemble(tmp_path / "small.h5").dataset
    for dataset in (large, again):
        assert dataset.identical(small)
        assert all(isinstance(dataset[q].variable._data.base, np.memmap | mmap) for q in dataset.data_vars)
