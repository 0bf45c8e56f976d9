"""Ensembles, arenas and searches on a dask cluster are those of one thread, bit for bit, also where it loses a worker."""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from dampyr.cli import cli
from dampyr.ground_motions import el_centro, kanai_tajimi
from dampyr.models import Damper
from dampyr.structures import Sensor, arena, control_law, ensemble, search_control, two_storey

MOTIONS = [el_centro(), *(kanai_tajimi(6.0, 0.02, seed=k, pga=3.0) for k in range(3))]


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    distributed = pytest.importorskip("distributed", reason="dask is not installed: pip install dampyr[cluster]")
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as connected,
    ):
        yield connected


@pytest.fixture(autouse=True)
def small_shards(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dampyr.structures.ensembles.ensemble_grid.CASES_PER_SHARD", 32)


def laws() -> list[Any]:
    noisy = {"accelerations": Sensor(noise=0.05, delay=1)}
    return [
        control_law("clipped_optimal_lqg", high=3.212, lag=0.01, sensors=noisy),
        control_law("on_off", high=3.212, lag=0.01),
        0.0,
    ]


@pytest.mark.prove
@pytest.mark.filterwarnings("ignore")  # dask's own, of ports and of closing; errors of dampyr still raise
def test_a_cluster_gives_the_same_numbers(cubics: Damper, client: Any) -> None:
    given = (two_storey(), MOTIONS, [None, cubics], [0.0, 1.98], np.linspace(0.2, 2.0, 10))
    with ThreadPoolExecutor(1) as one:
        alone = ensemble(*given, one).dataset
    calls: list[int] = []
    dataset = ensemble(*given, client.get_executor(), progress=lambda done, _: calls.append(done)).dataset
    assert dataset.identical(alone)
    assert len(calls) == 5
    assert calls[-1] == alone.attrs["cases"] == 160
    assert ensemble(*given, client).dataset.identical(alone)


@pytest.mark.prove
@pytest.mark.filterwarnings("ignore")
def test_an_arena_is_the_same_by_any_number_of_workers_and_with_one_killed(
    cubics: Damper, client: Any, tmp_path: Path
) -> None:
    """Laws with memory and noise on drawn dampers: one thread, three, two processes of dask, and two of which one is killed."""
    given = (two_storey(), MOTIONS, cubics, laws(), [0.5, 1.0, 1.5, 2.0])
    with ThreadPoolExecutor(1) as one:
        alone = ensemble(*given, one, seeds=3)
    wanted = arena(alone, "acceleration")

    def same(found: Any) -> None:
        assert found.dataset.identical(alone.dataset)
        compared = arena(found, "acceleration")
        np.testing.assert_array_equal(compared.wins, wanted.wins)
        np.testing.assert_array_equal(compared.wins_band, wanted.wins_band)
        assert compared.winner == wanted.winner

    with ThreadPoolExecutor(3) as three:
        same(ensemble(*given, three, seeds=3))
    same(ensemble(*given, client, seeds=3))
    killed: list[int] = []

    def kill(done: int, _: int) -> None:
        if not killed:
            killed.append(next(iter(client.run(os.getpid).values())))
            os.kill(killed[0], signal.SIGKILL)

    same(ensemble(*given, client, seeds=3, progress=kill, out=tmp_path / "killed.h5"))
    assert killed


@pytest.mark.prove
@pytest.mark.filterwarnings("ignore")
def test_a_search_on_a_cluster_goes_on_where_it_was_stopped(cubics: Damper, client: Any, tmp_path: Path) -> None:
    given = (two_storey(), [kanai_tajimi(3.0, 0.02, seed=(5, k), pga=3.0) for k in range(8)], cubics)
    inputs = [0.0, 1.0, 2.0, *laws()[:2]]
    with ThreadPoolExecutor(1) as one:
        alone = search_control(*given, inputs, [1, 2], [0.5, 1.0, 1.5], executor=one)

    class Stop(Exception):
        pass

    calls: list[int] = []

    def stop(done: int, _: int) -> None:
        calls.append(done)
        if len(calls) == 2:
            raise Stop

    with pytest.raises(Stop):
        search_control(*given, inputs, [1, 2], [0.5, 1.0, 1.5], executor=client, out=tmp_path, progress=stop)
    later: list[int] = []
    found = search_control(
        *given,
        inputs,
        [1, 2],
        [0.5, 1.0, 1.5],
        executor=client,
        out=tmp_path,
        progress=lambda done, _: later.append(done),
    )
    assert later[0] > calls[0]  # what was done was not done again
    assert found.names == alone.names
    np.testing.assert_array_equal(found.ranked, alone.ranked)
    np.testing.assert_array_equal(found.ratio_band, alone.ratio_band)


@pytest.mark.prove
@pytest.mark.filterwarnings("ignore")
def test_the_commands_compute_on_a_cluster(client: Any) -> None:
    words = ["--control", "on_off", "--voltage", "0", "--synthetic", "3", "--duration", "3", "--json"]
    address = client.scheduler.address
    for command in ("arena", "ensemble"):
        here = CliRunner().invoke(cli, [command, *words])
        there = CliRunner().invoke(cli, [command, *words, "--cluster", address])
        assert there.exit_code == 0, there.output
        assert json.loads(there.stdout) == json.loads(here.stdout)
    search = ["arena", "--search", "voltage=0:3:1", "--synthetic", "4", "--duration", "3", "--json"]
    here, there = (CliRunner().invoke(cli, [*search, *more]) for more in ([], ["--cluster", address]))
    assert json.loads(there.stdout) == json.loads(here.stdout)
