"""An ensemble in parts is the ensemble, whoever computed which; what is missing or does not belong is told."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from dampyr.errors import FileError, InputError
from dampyr.ground_motions import el_centro, kanai_tajimi
from dampyr.models import Damper
from dampyr.structures import collect, ensemble, read_ensemble, shear_building, two_storey, write_part
from dampyr.structures.ensembles.ensemble_grid import Cases, cases
from dampyr.structures.ensembles.job_array import ranges
from dampyr.structures.ensembles.store import progress_of

pytestmark = pytest.mark.filterwarnings("ignore:.*was calibrated:dampyr.errors.DampyrWarning")
SCALES = np.linspace(0.3, 1.5, 5)


def what(cubics: Damper, volts: tuple[float, ...] = (0.0, 0.5, 1.0)) -> Cases:
    motions = [el_centro(), kanai_tajimi(4.0, 0.02, seed=1, pga=2.0)]
    return cases(two_storey(), motions, [None, cubics], volts, SCALES)


@pytest.fixture(scope="module")
def folder(cubics: Damper, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("parts") / "new"
    for part in (3, 1, 2, 5, 4):
        write_part(what(cubics), part, 5, path)
    return path


def test_parts_are_the_whole(cubics: Damper, folder: Path, tmp_path: Path) -> None:
    motions = list(what(cubics).motions)
    whole = ensemble(two_storey(), motions, [None, cubics], [0.0, 0.5, 1.0], SCALES).dataset
    collected = collect(folder, tmp_path / "all.h5").dataset
    assert collected.drop_attrs().identical(whole.drop_attrs())
    assert collected.attrs["cases"] == whole.attrs["cases"]
    assert collected.attrs["judged"] >= whole.attrs["judged"]
    assert read_ensemble(tmp_path / "all.h5").dataset.identical(collected)


def test_parts_say_how_many_cases_leave_the_calibrated_displacement(cubics: Damper, tmp_path: Path) -> None:
    near = replace(cubics, ranges={"displacement": (0.0, 5e-3)})
    given = two_storey(), [el_centro()], [None, near], (0.0, 1.0), SCALES
    whole = ensemble(*given[:3], voltage=given[3], scales=given[4]).dataset
    assert "of 10 cases" in whole.attrs["outside"]
    for part in (1, 2, 3):
        write_part(cases(*given), part, 3, tmp_path)
    assert collect(tmp_path).dataset.attrs["outside"] == whole.attrs["outside"]


def test_small_shards_in_a_part_are_the_same(
    cubics: Damper, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("dampyr.structures.ensembles.ensemble_grid.CASES_PER_SHARD", 4)
    calls: list[tuple[int, int]] = []
    path = write_part(what(cubics), 2, 5, tmp_path, progress=lambda *now: calls.append(now))
    assert calls[-1] == (10, 10)
    assert len(calls) > 1
    with h5py.File(path) as one, h5py.File(folder / path.name) as other:
        np.testing.assert_array_equal(one["drift"], other["drift"])


def test_a_part_that_is_there_is_left(cubics: Damper, folder: Path) -> None:
    path = folder / "part-1-of-5.h5"
    before = path.stat().st_mtime_ns
    assert write_part(what(cubics), 1, 5, folder) == path
    assert path.stat().st_mtime_ns == before
    with pytest.raises(FileError, match="is a part of another ensemble"):
        write_part(what(cubics, (0.1,)), 1, 5, folder)


def test_what_is_missing_or_does_not_belong_is_told(cubics: Damper, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="holds no part of an ensemble"):
        collect(tmp_path)
    for part in (2, 3):
        write_part(what(cubics, (0.0,)), part, 4, tmp_path)
    with pytest.raises(InputError, match="2 of 4 parts are missing: 1,4"):
        collect(tmp_path)
    write_part(what(cubics, (0.1,)), 1, 4, tmp_path)
    write_part(what(cubics, (0.1,)), 4, 4, tmp_path)
    with pytest.raises(FileError, match="does not belong to part-1-of-4"):
        collect(tmp_path)
    write_part(what(cubics, (0.0,)), 1, 2, tmp_path)
    with pytest.raises(InputError, match="parts of 2 and of 4"):
        collect(tmp_path)
    with pytest.raises(InputError, match="part 0/4 does not exist; count from 1 to 4"):
        write_part(what(cubics), 0, 4, tmp_path)


def test_a_damaged_part_is_named(tmp_path: Path) -> None:
    (tmp_path / "part-1-of-1.h5").write_text("no", encoding="utf-8")
    with pytest.raises(FileError, match=r"part-1-of-1.h5: cannot be read as a part"):
        collect(tmp_path)


@pytest.mark.prove
def test_a_finished_file_reads_as_it_was(cubics: Damper, tmp_path: Path) -> None:
    path = tmp_path / "e.h5"
    buildings = [two_storey(), shear_building([1e3] * 3, [2e6] * 3, damping_ratio=0.03)]
    dataset = ensemble(
        buildings, el_centro(), [cubics, None], [0.0, 1.0], quantities=["drift", "force"], out=path
    ).dataset
    assert read_ensemble(path).dataset.identical(dataset)
    assert dataset.damper_name.values.tolist() == ["damper", "no damper"]
    assert dataset.pga.values == pytest.approx([el_centro().pga])
    assert progress_of(path) == (1, 1)
    with h5py.File(path, "a") as file:
        file["done"][0] = False
    with pytest.raises(FileError, match="is not finished: 0 of 1 shards"):
        read_ensemble(path)
    with pytest.raises(FileError, match="is not there"):
        read_ensemble(tmp_path / "none.h5")


def test_ranges_are_those_of_a_batch_system() -> None:
    assert ranges([1, 4, 5, 6, 9]) == "1,4-6,9"
