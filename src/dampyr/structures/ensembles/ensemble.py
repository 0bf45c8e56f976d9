r"""Ensembles: every building with every damper at every input under every motion at every scale, reduced to peaks.

The outer product is divided into shards (`dampyr.structures.ensembles.ensemble_batches`) that any executor can run; the result
holds the peaks of each case, not its histories, in labelled axes.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from contextlib import closing
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from dampyr.errors import FindingWarning
from dampyr.ground_motions import GroundMotion
from dampyr.options import takes
from dampyr.structures.building import Building
from dampyr.structures.building_options import EnsembleOptions
from dampyr.structures.ensembles.ensemble_accuracy import doubts
from dampyr.structures.ensembles.ensemble_batches import Shard, run_shard
from dampyr.structures.ensembles.ensemble_grid import Cases, cases
from dampyr.structures.ensembles.ensemble_result import EnsembleResult
from dampyr.structures.ensembles.ensemble_workers import Workers, count_of, executor_of, telling_of_the_lost
from dampyr.structures.ensembles.store import Store
from dampyr.structures.floor_loads import refuse_loads
from dampyr.structures.sites import warn_of_parts

IN_FLIGHT = 4  # shards per worker that wait or run at a time: bounds the memory, and no worker waits for the next
Progress = Callable[[int, int], None]


@takes(EnsembleOptions)
def ensemble(
    buildings: Building | Sequence[Building],
    motions: GroundMotion | Sequence[GroundMotion],
    dampers: Any = None,
    voltage: Any = None,
    scales: ArrayLike = 1.0,
    executor: Workers | None = None,
    options: EnsembleOptions | None = None,
    *,
    current: Any = None,
    out: str | Path | None = None,
    progress: Progress | None = None,
    **keywords: Any,
) -> EnsembleResult:
    """Peaks of every building with every damper at every input under every motion at every scale, and fragility curves.

    Parameters
    ----------
    buildings, motions
        one or a list.
    dampers
        a damper (it stands in storey 1), a placement ``{storey: damper or list}``, None for the bare building, or a list of
        these; ``damper.draws(n, seed)`` is such a list, and ``draws`` makes one of each damper.
    voltage, current
        the inputs, one or several in a list or an array: numbers [V], [A], which are constant, and control laws
        (:func:`~dampyr.structures.control_laws.control_law`). ``input_name`` tells them apart.
    scales
        factors of the motions, one or a list.
    executor
        anything with ``submit`` of :class:`concurrent.futures.Executor`, or the ``Client`` of a dask cluster, whose workers
        then are kept busy, however many there are; default: one thread per core (the kernels need no lock). The numbers are
        the same to the last bit, whoever computes them, and where a worker of a cluster is killed another takes its shards.
    options
        the further arguments as one object; those that are given by name take their places.
    out
        write to this HDF5 file as shards are done; a run that was interrupted resumes where it stopped. Where a quantity has
        more than 256 MB its values stay in the file and are read on access.
    progress
        called with the number of cases that are done and of all.

    Returns
    -------
    EnsembleResult
        ``dataset``, an ``xarray.Dataset`` of the peaks with dims (building, damper, input, motion, scale, ...), and a fragility
        curve for each of ``limits``. Quantities are displacement and drift [m], acceleration [m/s2] (absolute), force [N],
        stroke [m] and energy [J].

    Peaks are those of the motion itself, between steps too. Peak displacements and drifts above 0.1 mm and 1 % of the largest
    of their case are good to 2 % with accuracy fast (0.1 % in the standard suite) and to 0.1 % with strict. Smaller ones have
    no bound: of a floor that a stuck damper locks to micrometres fast missed 9 %, strict 0.7 %. Peak accelerations are less
    sharp.
    Under control laws the step of each case is halved until no decision that hangs on it changes its peaks, as `respond` does
    for the same accuracy; ``attrs["unconverged"]`` counts the cases that did not get there, where there are any. Cases end with
    the record, or ``after`` seconds later; Sa in the labels is of the motions with their rest.

    ``attrs`` of the dataset hold the measured error, of all peaks (``error_estimate``) and of those above the sizes above
    (``error_estimate_moving``), on how many cases it was measured (``judged``: the hardest, and others at random), how many
    grew without bound (their peaks are NaN), and in ``outside`` how many leave the calibrated displacement of a damper. A
    reduced structure is taken as `respond` takes it, and ``truncation_error``, ``truncation_error_acceleration`` and
    ``truncation_error_force`` are how far displacements and drifts, accelerations and forces of the judged cases lie from those
    with half as many coordinates.

    Warns (:class:`~dampyr.errors.DampyrWarning`) of an error above the bound of the accuracy, and of dampers with a part that
    is not for buildings.

    Raises
    ------
    InputError
        An argument is wrong; before anything runs.
    DampyrError
        All workers were lost; a run with ``out`` goes on from what was done.

    Examples
    --------
    >>> import dampyr as dp
    >>> motions = [dp.ground_motions.kanai_tajimi(5.0, 0.01, seed=(7, k), pga=3.0) for k in range(1, 4)]
    >>> damper = dp.studies.raminelli_2020.damper()
    >>> building = dp.structures.two_storey()
    >>> peaks = dp.structures.ensemble(building, motions, damper, voltage=[0.0, 1.98], scales=[0.5, 1.0]).dataset
    >>> dict(peaks.drift.sizes)
    {'building': 1, 'damper': 1, 'input': 2, 'motion': 3, 'scale': 2, 'storey': 2}
    """
    refuse_loads("ensemble", keywords)
    chosen = EnsembleOptions.of("ensemble", options, keywords)
    chosen.checked_limits()
    what = cases(buildings, motions, dampers, voltage, scales, chosen, current=current)
    warn_of_parts(site for d in range(len(what.placements)) for site in what.sites_of(0, d, 0))
    result = EnsembleResult(run(what, executor, out, progress))
    return result.evaluated(chosen.limits, chosen.height, chosen.intensity, chosen.seed)


def run(
    what: Cases, executor: Workers | None = None, out: str | Path | None = None, progress: Progress | None = None
) -> Any:
    """The dataset of checked cases; see `ensemble`."""
    store = Store(what, out)
    waiting = store.missing()
    done = what.size - sum(len(what.lines_of(k, store.shards)) for k in waiting) * len(what.scales)
    try:
        with (
            telling_of_the_lost("" if out is None else str(out)),
            closing(completed(executor, what, store.shards, waiting)) as shards,
        ):
            for shard in shards:
                store.put(shard)
                done += len(shard.lines) * len(what.scales)
                if progress:
                    progress(done, what.size)
    finally:
        store.close()
    dataset = store.dataset()
    warn_of(dataset)
    return dataset


def completed(workers: Workers | None, what: Cases, shards: int, waiting: list[int]) -> Generator[Shard, None, None]:
    """Yield shards as they finish, no more than a few per worker submitted at a time."""
    left, running = iter(waiting), set[Future[Shard]]()
    with executor_of(workers) as pool:
        while True:
            max_running = IN_FLIGHT * count_of(workers, pool)
            while len(running) < max_running and (k := next(left, None)) is not None:
                running.add(pool.submit(run_shard, k, shards, what))
            if not running:
                return
            finished, running = wait(running, return_when=FIRST_COMPLETED)
            for future in sorted(finished, key=_has_failed):  # what was computed is taken before an error ends the run
                yield future.result()


def _has_failed(future: Future[Shard]) -> bool:
    return future.cancelled() or future.exception() is not None


def warn_of(dataset: Any) -> None:
    """Warn of errors above the bound of the accuracy, and of cases that grew without bound."""
    for sentence in doubts(dataset.attrs):
        warnings.warn(sentence, FindingWarning, stacklevel=4)
