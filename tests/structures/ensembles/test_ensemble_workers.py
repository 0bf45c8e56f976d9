"""Who computes: what is taken, how many run at a time, and what is said where all are lost or none answers."""

from concurrent.futures import Future, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from dampyr.cli import cli
from dampyr.errors import DampyrError, InputError
from dampyr.ground_motions import kanai_tajimi
from dampyr.structures import ensemble, read_ensemble, two_storey
from dampyr.structures.ensembles import ensemble_workers as workers
from dampyr.structures.ensembles.ensemble_batches import run_shard
from dampyr.structures.ensembles.store import progress_of

MOTIONS = [kanai_tajimi(3.0, 0.02, seed=(5, k), pga=3.0) for k in range(6)]


class Pool:
    """An executor that runs at once, loses its workers after some tasks, and counts what waits."""

    def __init__(self, lost_after: int = 1000, threads: int = 2) -> None:
        self.lost_after, self.threads, self.submitted = lost_after, threads, 0

    def submit(self, function: Any, *arguments: Any) -> Future[Any]:
        self.submitted += 1
        future: Future[Any] = Future()
        if self.submitted > self.lost_after:
            future.set_exception(BrokenProcessPool("a process was terminated abruptly"))
        else:
            future.set_result(function(*arguments))
        return future


class Client(Pool):
    """A cluster's client, as dask has it."""

    def get_executor(self) -> Any:
        return self

    def nthreads(self) -> dict[str, int]:
        return {"tcp://a:1": self.threads, "tcp://b:1": 5}


@pytest.fixture(autouse=True)
def small_shards(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dampyr.structures.ensembles.ensemble_grid.CASES_PER_SHARD", 2)


def test_so_many_tasks_wait_as_the_workers_can_take(monkeypatch: pytest.MonkeyPatch) -> None:
    with ThreadPoolExecutor(7) as pool:
        assert workers.count_of(None, pool) == workers.count_of(pool, pool) == 7
    client = Client()
    assert workers.count_of(client, client) == 7
    client.threads = 1  # a worker is gone
    assert workers.count_of(client, client) == 6
    monkeypatch.setattr("os.cpu_count", lambda: 3)
    assert workers.count_of(Pool(), Pool()) == 3


def test_a_client_of_a_cluster_is_taken_as_an_executor_is() -> None:
    alone = ensemble(two_storey(), MOTIONS).dataset
    assert ensemble(two_storey(), MOTIONS, executor=Client()).dataset.identical(alone)
    assert ensemble(two_storey(), MOTIONS, executor=Pool()).dataset.identical(alone)
    with pytest.raises(InputError, match=r"executor is a int; give an executor of concurrent\.futures, or the Client"):
        ensemble(two_storey(), MOTIONS, executor=4)


def test_where_all_workers_are_lost_the_next_run_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "peaks.h5"
    with pytest.raises(DampyrError, match=r"workers were lost.*what was done is in .*peaks\.h5: run the same again"):
        ensemble(two_storey(), MOTIONS, executor=Pool(lost_after=1), out=out)
    done, shards = progress_of(out)
    assert (done, shards > 1) == (1, True)
    ran: list[int] = []

    def counted(number: int, *rest: Any) -> Any:
        ran.append(number)
        return run_shard(number, *rest)

    monkeypatch.setattr("dampyr.structures.ensembles.ensemble.run_shard", counted)
    dataset = ensemble(two_storey(), MOTIONS, executor=Pool(), out=out).dataset
    assert len(ran) == len(set(ran)) == shards - 1  # the one that was done is not done again
    assert dataset.identical(ensemble(two_storey(), MOTIONS).dataset)
    assert read_ensemble(out).dataset.equals(dataset)
    with pytest.raises(DampyrError, match="give out=, a file, so that the next run goes on"):
        ensemble(two_storey(), MOTIONS, executor=Pool(lost_after=1))


def test_other_errors_stay_what_they_are() -> None:
    with pytest.raises(ZeroDivisionError), workers.telling_of_the_lost():
        raise ZeroDivisionError


@pytest.mark.parametrize("command", ["ensemble", "arena"])
def test_what_is_wrong_on_the_command_line_is_said(command: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(workers, "CONNECT", 0.3)
    words = [command, "--voltage", "0", "--voltage", "1", "--synthetic", "2", "--duration", "2"]
    both = CliRunner().invoke(cli, [*words, "--workers", "2", "--cluster", "tcp://localhost:8786"])
    assert both.exit_code == 2
    assert "give one of the two" in both.output
    pytest.importorskip("distributed", reason="dask is not installed: pip install dampyr[cluster]")
    none = CliRunner().invoke(cli, [*words, "--cluster", "tcp://127.0.0.1:9"])
    assert none.exit_code == 2
    assert "no dask scheduler answers at tcp://127.0.0.1:9" in none.output
