"""Ensembles against single responses, whoever runs them and however the work is cut."""

from __future__ import annotations

import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from mmap import mmap
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest

from dampyr.errors import DampyrWarning, FileError, InputError
from dampyr.ground_motions import GroundMotion, el_centro, kanai_tajimi
from dampyr.models import Damper
from dampyr.models.codegen.composition import compose
from dampyr.show.structures.ensemble_result import trust
from dampyr.structures import (
    Building,
    collect,
    control_law,
    ensemble,
    read_ensemble,
    respond,
    shear_building,
    two_storey,
    write_part,
)
from dampyr.structures.batch.assemble import QUANTITIES
from dampyr.structures.batch.engine import engine
from dampyr.structures.batch.modal import classical_modes
from dampyr.structures.ensembles.ensemble import run
from dampyr.structures.ensembles.ensemble_batches import run_shard
from dampyr.structures.ensembles.ensemble_grid import cases
from dampyr.structures.ensembles.store import progress_of
from dampyr.structures.sites import connections

pytestmark = pytest.mark.filterwarnings("ignore:.*was calibrated:dampyr.errors.DampyrWarning")


@pytest.fixture(scope="module")
def motions() -> list[GroundMotion]:
    """Of different lengths, so that lanes end at different times."""
    return [
        el_centro(),
        kanai_tajimi(duration=8.0, dt=0.02, seed=1, pga=3.0),
        kanai_tajimi(8.0, dt=0.01, seed=2, pga=2.0),
    ]


def test_the_peaks_are_those_of_single_responses(cubics: Damper, motions: list[GroundMotion]) -> None:
    dataset = ensemble(two_storey(), motions, cubics, [0.0, 2.25], [0.5, 2.0], accuracy="strict").dataset
    assert dataset.attrs["error_estimate"] < 5e-4
    for u in (0.0, 2.25):
        for k, motion in enumerate(motions):
            for scale in (0.5, 2.0):
                one = respond(two_storey(), motion.scaled(scale), {1: cubics}, voltage=u, accuracy=5e-5)
                here = dataset.isel(building=0, damper=0, motion=k).sel(input=u, scale=scale)
                np.testing.assert_allclose(here.displacement, one.peak_displacement, rtol=1e-3)
                np.testing.assert_allclose(here.drift, one.peak_drift, rtol=1e-3)
                np.testing.assert_allclose(here.force, one.peak_force, rtol=1e-3)
                np.testing.assert_allclose(here.stroke, one.peak_drift[:1], rtol=1e-3)
                np.testing.assert_allclose(here.energy, one.energy.dampers[:, -1], rtol=2e-3)
                np.testing.assert_allclose(here.acceleration, one.peak_acceleration, rtol=2e-2)


def test_cases_go_on_after_their_records(cubics: Damper, tmp_path: Path) -> None:
    """As `respond` does; the file, its parts and the page say for how long, and a file without it is another ensemble."""
    short = GroundMotion(el_centro().acceleration[:110], 0.02, "start of El Centro")
    given = (two_storey(), short, [None, cubics], 1.0)
    data = ensemble(*given, accuracy="strict", after=2.5, out=tmp_path / "peaks.h5").dataset
    for k, dampers in enumerate(({}, {1: cubics})):
        one = respond(two_storey(), short, dampers, voltage=1.0 if dampers else None, after=2.5)
        np.testing.assert_allclose(data.drift.values[0, k].ravel(), one.peak_drift, rtol=1e-3)
    assert data.drift.values[0, 0].ravel()[1] > 1.05 * ensemble(*given).dataset.drift.values[0, 0].ravel()[1]
    assert read_ensemble(tmp_path / "peaks.h5").dataset.identical(data)
    assert data.attrs["after_s"] == 2.5
    assert "Each case ends 2.5 s after the record." in trust(data)
    with pytest.raises(FileError, match="holds another ensemble"):
        ensemble(*given, accuracy="strict", out=tmp_path / "peaks.h5")
    write_part(cases(*given, accuracy="strict", after=2.5), 1, 1, tmp_path / "parts")
    assert collect(tmp_path / "parts").dataset.attrs["after_s"] == 2.5
    with pytest.raises(InputError, match="after = -1 s is not allowed"):
        ensemble(*given, after=-1)


@pytest.mark.parametrize("precision", [64, pytest.param(32, marks=pytest.mark.prove)])
def test_a_bare_building(precision: int) -> None:
    dataset = ensemble(two_storey(), el_centro(), scales=[1.0, -1.0], precision=precision).dataset
    np.testing.assert_allclose(dataset.displacement[0, 0, 0, 0, 0, 0], 45.5340e-3, rtol=1e-4)  # FACTS, finding 13
    np.testing.assert_array_equal(dataset.displacement[..., 0, :], dataset.displacement[..., 1, :])
    assert "force" not in dataset or dataset.sizes["site"] == 0


def test_single_precision_is_good_for_four_digits(cubics: Damper) -> None:
    double, single = (ensemble(two_storey(), el_centro(), cubics, [1.0], precision=p).dataset for p in (64, 32))
    np.testing.assert_allclose(single.drift, double.drift, rtol=2e-4)
    assert not np.array_equal(single.drift, double.drift)


def test_bit_identical_whoever_runs_it(cubics: Damper, motions: list[GroundMotion]) -> None:
    given = (two_storey(), motions, cubics, [0.0, 1.0], np.linspace(0.2, 2.0, 23))
    alone = ensemble(*given).dataset
    with ThreadPoolExecutor(1) as one, ProcessPoolExecutor(2, mp_context=get_context("spawn")) as processes:
        for executor in (one, processes):
            assert ensemble(*given, executor).dataset.identical(alone)


def test_bit_identical_however_it_is_cut(cubics: Damper, motions: list[GroundMotion]) -> None:
    what = cases(two_storey(), motions, [cubics, None], [0.0, 1.0], np.linspace(0.2, 2.0, 7))
    whole = run_shard(0, 1, what).values
    for shards in (2, 5):
        parts = [run_shard(k, shards, what).values for k in range(shards)]
        for quantity, values in whole.items():
            np.testing.assert_array_equal(np.concatenate([p[quantity] for p in parts]), values)


@pytest.mark.parametrize(
    ("lines", "scales", "shards"), [(1, 100_000, 1), (21, 2400, 21), (100, 10, 1), (1000, 10, 4), (10_000, 100, 123)]
)
def test_shards_are_many_enough_to_share_out_and_worth_their_beginning(lines: int, scales: int, shards: int) -> None:
    what = cases(two_storey(), el_centro(), [None] * lines, None, np.linspace(0.1, 2.0, scales))
    assert what.shards() == shards
    shard_lines = [what.lines_of(k, shards) for k in range(shards)]
    assert all(shard_lines)
    assert sum(map(len, shard_lines)) == lines


def test_shards_under_laws_are_small(cubics: Damper) -> None:
    """A case under a law takes as long as thousands without."""
    laws = [control_law("on_off", high=2.0), 0.0]
    assert cases(two_storey(), el_centro(), [cubics] * 20, laws, [1.0, 2.0]).shards() == 10


@pytest.mark.prove
@pytest.mark.parametrize("dashpot", [0.0, 2e3])  # in the second storey: with it the modes are complex
def test_modal_and_dense_agree(monkeypatch: pytest.MonkeyPatch, cubics: Damper, dashpot: float) -> None:
    classical = shear_building([1e3] * 5, [2e6] * 5, damping_ratio=0.03)
    row = classical.connection(2)
    building = Building(classical.M, classical.C + dashpot * np.outer(row, row), classical.K)
    assert (classical_modes(building) is None) == bool(dashpot)
    given = (building, el_centro(), {1: cubics, 3: cubics}, [1.0], [1.0, 2.0])
    modal = ensemble(*given).dataset
    monkeypatch.setattr("dampyr.structures.batch.engine.basis_of", lambda _: None)
    dense = ensemble(*given).dataset
    for quantity in modal.data_vars:
        np.testing.assert_allclose(modal[quantity], dense[quantity], rtol=1e-10)


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
    for k in range(7):
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


HELD = {
    "dahl.kx": 1400.0, "dahl.kw": 227.0, "dahl.rho": 18800.0, "delay.tau": 0.007, "compliance.s": 5e-7, "inertia.m": 3.0,
    "hyperbolic_tangent.c": 1500.0, "hyperbolic_tangent.ft": 200.0, "hyperbolic_tangent.v0": 0.0032, "spring.k0": 900.0,
    "hyperbolic_tangent.s": 0.13, "bouc_wen.c0": 1400.0, "bouc_wen.k0": 500.0, "bouc_wen.kw": 227.0, "bouc_wen.rho": 18800.0,
    "bouc_wen.sigma": 0.8, "bouc_wen.n": 1.5, "free_play.g": 4e-4, "free_play.fc": 20.0,
    "hysteretic_biviscous.c": 1400.0, "hysteretic_biviscous.fy": 200.0, "hysteretic_biviscous.vy": 0.004,
    "hysteretic_biviscous.vh": 0.003, "sigmoid.ft": 200.0, "sigmoid.c": 1500.0, "sigmoid.vk": 0.004, "sigmoid.vh": 0.003,
}  # fmt: skip


def of(name: str) -> Damper:
    return Damper(name, {key: HELD[key] for key in compose(name).parameters})


@pytest.mark.parametrize(
    ("name", "one_by_one"),
    [
        pytest.param("hyperbolic_tangent + spring", 0, marks=pytest.mark.prove),
        pytest.param("bouc_wen", 0, marks=pytest.mark.prove),
        pytest.param("sigmoid", 0, marks=pytest.mark.by_hand),
        pytest.param("dahl + delay", 0, marks=pytest.mark.by_hand),
        pytest.param("dahl + compliance", 0, marks=pytest.mark.by_hand),
        pytest.param("hyperbolic_tangent + compliance", 0, marks=pytest.mark.by_hand),
        pytest.param("dahl + free_play", 0, marks=pytest.mark.prove),
        pytest.param("hysteretic_biviscous + spring + compliance", 0, marks=pytest.mark.prove),
        pytest.param("dahl + compliance + delay", 0, marks=pytest.mark.prove),
        pytest.param("dahl + inertia", 1, marks=pytest.mark.prove),
    ],
)
def test_every_kind_of_damper(name: str, one_by_one: int) -> None:
    motion = GroundMotion(el_centro().acceleration[:400], 0.02)
    dataset = ensemble(
        two_storey(), motion, of(name), [0.0], quantities=("drift", "force", "energy"), accuracy="strict"
    ).dataset
    assert dataset.attrs["one_by_one"] == one_by_one
    one = respond(two_storey(), motion, {1: of(name)}, voltage=0.0, accuracy=5e-5)
    np.testing.assert_allclose(dataset.drift[0, 0, 0, 0, 0], one.peak_drift, rtol=1.5e-3)
    np.testing.assert_allclose(dataset.force[0, 0, 0, 0, 0], one.peak_force, rtol=2e-3)
    np.testing.assert_allclose(dataset.energy[0, 0, 0, 0, 0], one.energy.dampers[:, -1], rtol=3e-3)


def test_a_delay_of_nothing_is_no_delay() -> None:
    given = dict(zip(compose("dahl + delay").parameters, (1400.0, 227.0, 18800.0, 0.0)))
    dataset = ensemble(two_storey(), el_centro(), [Damper("dahl + delay", given), of("dahl")], [0.0]).dataset
    assert dataset.attrs["one_by_one"] == 0
    np.testing.assert_array_equal(dataset.drift[:, 0], dataset.drift[:, 1])


@pytest.mark.prove  # its kernels take long to compile
def test_several_dampers_of_different_kinds() -> None:
    placement = {1: [of("dahl"), of("hyperbolic_tangent")], 2: of("dahl + delay")}
    motion = GroundMotion(el_centro().acceleration[:400], 0.02)
    dataset = ensemble(two_storey(), motion, placement, [0.0], accuracy="strict").dataset
    one = respond(two_storey(), motion, placement, voltage=0.0, accuracy=5e-5)
    np.testing.assert_allclose(dataset.drift[0, 0, 0, 0, 0], one.peak_drift, rtol=1e-3)
    np.testing.assert_allclose(dataset.force[0, 0, 0, 0, 0], one.peak_force, rtol=2e-3)


@pytest.mark.prove
def test_unbounded_cases_are_counted(motions: list[GroundMotion]) -> None:
    feeding = Damper("spring + dahl", {"spring.k0": -3e5, "dahl.kx": 1.0, "dahl.kw": 1.0, "dahl.rho": 10.0})
    with pytest.warns(DampyrWarning, match="1 cases grew without bound"):
        dataset = ensemble(two_storey(), motions[0].scaled(1e6), feeding, [0.0], [1e300]).dataset
    assert np.isnan(dataset.drift).all()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"voltage": [1.0], "current": [1.0]}, "both voltage= and current="),
        ({"voltage": ["a"]}, "voltage: 'a' is not a quantity; write a number and a unit"),
        ({"accuracy": "rough"}, "choose from fast, strict"),
        ({"precision": 16}, "choose from 64, 32"),
        ({"quantities": ["shear"]}, "choose from displacement"),
        ({"scales": []}, "must be finite numbers"),
        ({"dampers": []}, "dampers is empty"),
        ({"voltage": None}, "has no voltage"),
        ({"voltage": [9.0]}, "range"),
    ],
)
def test_what_is_wrong_is_said_before_anything_runs(cubics: Damper, given: dict, message: str) -> None:
    arguments = {"dampers": cubics, "voltage": [0.0]} | given
    with pytest.raises(ValueError, match=message):
        ensemble(two_storey(), el_centro(), **arguments)


def test_lists_of_the_wrong_thing_are_refused() -> None:
    with pytest.raises(InputError, match="motions holds a int; give one GroundMotion"):
        ensemble(two_storey(), [3])


def test_one_engine_serves_dampers_of_the_same_parts(cubics: Damper) -> None:
    """A block of different dampers gives each what it would get alone."""
    others = [
        cubics,
        *(
            Damper("dahl", dict(zip(("dahl.kx", "dahl.kw", "dahl.rho"), v)))
            for v in ((800.0, 60.0, 3e4), (3e3, 400.0, 1e4))
        ),
    ]
    together = ensemble(two_storey(), el_centro(), others, [0.0]).dataset
    for k, damper in enumerate(others):
        np.testing.assert_array_equal(
            together.drift[:, k], ensemble(two_storey(), el_centro(), damper, [0.0]).dataset.drift[:, 0]
        )


def test_the_spread_of_a_motion_is_run_through_once(cubics: Damper) -> None:
    """The unit that a scheduler runs gives the same as the whole."""
    what = cases(two_storey(), el_centro(), cubics, [0.0], [1.0, 2.0])
    assert what.size == 2
    np.testing.assert_array_equal(run(what).drift.values.reshape(1, 2, 2), run_shard(0, 1, what).values["drift"])


def test_an_engine_is_told_its_steps(cubics: Damper) -> None:
    """Half the step moves the peaks by less than the fourth order allows."""
    site = cases(two_storey(), el_centro(), cubics, [0.0], [1.0]).sites_of(0, 0, 0)
    rows = connections(two_storey(), site)
    peaks = []
    for m in (4, 8, 16):
        one = engine(two_storey(), rows, (site[0].composition,), 0.02, m, QUANTITIES)
        peaks.append(
            one.run([el_centro().acceleration], [site[0].values[None]], np.zeros((1, 1)))["displacement"][0, 0]
        )
    assert abs(peaks[1] - peaks[2]) < abs(peaks[0] - peaks[2]) < 1e-3 * peaks[2]
