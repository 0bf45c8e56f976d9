"""An ensemble on a dask cluster is the ensemble, bit for bit."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from dampyr.ground_motions import el_centro, kanai_tajimi
from dampyr.models import Damper
from dampyr.structures import ensemble, two_storey


@pytest.mark.prove
@pytest.mark.filterwarnings("ignore")  # dask's own, of ports and of closing; errors of dampyr still raise
def test_a_cluster_gives_the_same_numbers(cubics: Damper, monkeypatch: pytest.MonkeyPatch) -> None:
    distributed = pytest.importorskip("distributed", reason="dask is not installed: pip install dampyr[cluster]")
    monkeypatch.setattr("dampyr.structures.ensembles.ensemble_grid.CASES_PER_SHARD", 32)
    motions = [el_centro(), *(kanai_tajimi(6.0, 0.02, seed=k, pga=3.0) for k in range(3))]
    given = (two_storey(), motions, [None, cubics], [0.0, 1.98], np.linspace(0.2, 2.0, 10))
    with ThreadPoolExecutor(1) as one:
        alone = ensemble(*given, one).dataset
    calls: list[int] = []
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        dataset = ensemble(*given, client.get_executor(), progress=lambda done, _: calls.append(done)).dataset
    assert dataset.identical(alone)
    assert len(calls) == 5
    assert calls[-1] == alone.attrs["cases"] == 160
