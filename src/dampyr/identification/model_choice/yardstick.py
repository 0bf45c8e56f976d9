"""The yardstick of a leaderboard: black boxes that are trained on the same parts of the records, and what they show is left.

A network of two layers of 48 and a Gaussian process predict the force from the motion alone: velocity and acceleration, nine
earlier velocities, the path and the greatest speed since the last reversal, the place about the middle of the motion, and the
input. They know nothing of dampers, have some three thousand numbers, and become no card: what they predict better than the
best model is structure that no part has.

Which feature carries it is told by boosted trees of the residual of the chosen model. They see the velocity, its direction and
the input, and one feature more: by how much that lowers their error in thirds of the records that they were not trained on.
"""

from __future__ import annotations

import itertools
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dampyr.errors import InputError
from dampyr.identification.fits.result import Fit
from dampyr.identification.model_choice.screening import BETWEEN, choose_splits
from dampyr.identification.scoring.score import compare
from dampyr.identification.scoring.scoring_window import too_short
from dampyr.identification.scoring.splits import split_tasks
from dampyr.phrases import percent
from dampyr.records import Record, with_velocity
from dampyr.records.checks.quality import motion_start
from dampyr.records.cycle_analysis.cycles import turning_points

Array = NDArray[np.float64]
LAGS = 0.01 * np.array([1, 2, 3, 5, 8, 13, 21, 34, 55])  # s: from within a reversal to a period
SAMPLES = 600  # of a record, evenly taken
SCALE_SAMPLES = 300  # of all records, for the scales of a process, which are slow to find
PROCESS_SAMPLES = 2000  # of all records, for the process itself
EPOCHS = 150
PARTS = 3  # of the records, of which each is predicted by trees of the others
NETWORK, PROCESS = "a network of two layers", "a Gaussian process"
CARRIES = 0.05  # of the residual: less is not worth a sentence
USUAL = ("velocity", "direction", "input")  # what every model of a damper is a function of
#: what else a residual may go with
GROUPS = {
    "the place in the motion": ("place",),
    "the path since the reversal": ("path",),
    "the greatest speed since the reversal": ("greatest_speed",),
    "the energy dissipated so far (heat)": ("energy",),
    "the time in the record (drift)": ("time",),
}
MISSING = (
    "the yardstick of black boxes needs the package scikit-learn, which is not installed: run "
    'pip install "dampyr[yardstick]", or leave it out'
)


@dataclass(frozen=True)
class Yardstick:
    """A black box on the parts of a leaderboard: mean L1 ratios as of `Finalist`; ``numbers`` are those that it has fitted."""

    name: str
    error: float
    l1: float
    unseen_input: float
    numbers: int
    seconds: float


def check_installed() -> None:
    """Raise :class:`~dampyr.errors.InputError` without scikit-learn, before minutes of a search."""
    try:
        import sklearn  # noqa: F401
    except ImportError:
        raise InputError(MISSING) from None


def train_yardsticks(
    records: Sequence[Record], folds: int, seed: int, settling: float, progress: Callable[[float], None]
) -> tuple[Yardstick, ...]:
    """The black boxes on the splits that a leaderboard ranks by, with its ``seed``."""
    tables = {record.name: _Features.of(record) for record in records}
    splits = [(split, split_tasks(records, split, folds, seed)) for split in choose_splits(records)]
    total = 2 * sum(len(tasks) for _, tasks in splits)
    yardsticks, done = [], 0
    for name, train in ((NETWORK, _train_network), (PROCESS, _train_process)):
        begun, numbers, errors = time.perf_counter(), 0, {}
        for split, tasks in splits:
            by_input: dict[float, list[float]] = {}
            for task in tasks:
                predict, numbers = train([tables[r.name] for r in task.fitted], seed)
                for target in task.predicted:
                    record = target.record
                    if not too_short(record, settling):
                        score = compare(record, predict(tables[record.name]), settling)
                        by_input.setdefault(round(float(record.input_value or 0.0), 9), []).append(score.l1)
                done += 1
                progress(done / total)
            errors[split] = float(np.mean([np.mean(values) for values in by_input.values()]))
        by_record, unseen = errors["record"], errors.get("input", float("nan"))
        error = by_record if np.isnan(unseen) else (1.0 - BETWEEN) * by_record + BETWEEN * unseen
        yardsticks.append(Yardstick(name, error, by_record, unseen, numbers, time.perf_counter() - begun))
    return tuple(yardsticks)


def describe_what_is_left(l1: float, yardsticks: Sequence[Yardstick], carried: Mapping[str, float]) -> str:
    """The difference of the best model, of mean L1 ratio ``l1``, and the best black box, and what the residual goes with."""
    best = min(yardsticks, key=lambda yardstick: yardstick.l1)
    text = f"of records that were left out the model misses {percent(l1)} (L1) and {best.name} {percent(best.l1)}"
    left = 100 * (l1 - best.l1)
    text += f": {left:.2g} points are structure that no part has" if left > 0.0 else ": the black box sees nothing more"
    if not carried:
        return f"{text}; the residual goes with no feature of motion or test by more than chance"
    shares = ", ".join(f"{name} ({100 * share:.0f} %)" for name, share in list(carried.items())[:2])
    return f"{text}; the residual goes most with {shares}"


@dataclass(frozen=True)
class _Features:
    """One record as the black boxes see it: ``columns`` (n, k), their ``names``, and the force (n,) less its mean."""

    columns: Array
    names: tuple[str, ...]
    force: Array
    moving: NDArray[np.int64]  # samples of the motion

    @classmethod
    def of(cls, record: Record, further: Mapping[str, Array] | None = None) -> _Features:
        moved = record if record.velocity is not None else with_velocity(record)
        t, x, v = moved.time, moved.displacement, moved.velocity
        assert v is not None
        middle = 0.5 * (float(x.max()) + float(x.min()))
        path, greatest = _since_reversal(record, v)
        columns = {
            "velocity": v,
            "acceleration": np.gradient(v, t),
            "place": x - middle,
            "path": path,
            "greatest_speed": greatest,
            "direction": np.sign(v),
            "input": np.broadcast_to(0.0 if record.input_channel is None else record.input_channel, t.shape),
            **{f"earlier {k}": np.interp(t - lag, t, v) for k, lag in enumerate(LAGS)},
            **(further or {}),
        }
        moving = np.flatnonzero(t >= motion_start(record))
        return cls(
            np.column_stack(list(columns.values())),
            tuple(name.split(" ")[0] for name in columns),
            record.force - float(np.mean(record.force[moving])),
            moving,
        )

    def only(self, names: Sequence[str]) -> _Features:
        """With these columns alone."""
        return replace(self, columns=self.columns[:, np.isin(self.names, names)], names=tuple(names))

    def evenly(self, count: int) -> NDArray[np.int64]:
        """At most ``count`` samples of the motion."""
        return self.moving[:: max(1, len(self.moving) // count)]


def _since_reversal(record: Record, v: Array) -> tuple[Array, Array]:
    """The path in m and the greatest speed in m/s since the last turning point, (n,) each."""
    steps = np.abs(np.diff(record.displacement, prepend=record.displacement[0]))
    path, greatest = np.empty(record.n), np.empty(record.n)
    edges = [0, *map(int, turning_points(record)), record.n]
    for first, last in itertools.pairwise(edges):
        path[first:last] = np.cumsum(steps[first:last])
        greatest[first:last] = np.maximum.accumulate(np.abs(v[first:last]))
    return path, greatest


Predict = Callable[[_Features], Array]


def _gather(tables: Sequence[_Features], count: int) -> tuple[Array, Array, Array, Array, float]:
    """Standardised features and forces of ``count`` samples of each record, with the mean and the spread of the features, and
    the size of the forces."""
    at = [table.evenly(count) for table in tables]
    X = np.concatenate([table.columns[k] for table, k in zip(tables, at, strict=True)])
    y = np.concatenate([table.force[k] for table, k in zip(tables, at, strict=True)])
    mean, spread = X.mean(axis=0), X.std(axis=0)
    spread[spread < 1e-12 * np.maximum(np.abs(mean), 1e-300)] = 1.0  # a feature that is one number says nothing
    return (X - mean) / spread, y, mean, spread, max(float(y.std()), 1e-300)


def _train_network(tables: Sequence[_Features], seed: int) -> tuple[Predict, int]:
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.neural_network import MLPRegressor

    X, y, mean, spread, size = _gather(tables, SAMPLES)
    network = MLPRegressor(hidden_layer_sizes=(48, 48), activation="tanh", alpha=1e-3, learning_rate_init=1e-3,
                           batch_size=min(256, len(y)), max_iter=EPOCHS, tol=0.0, random_state=seed)  # fmt: skip
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # it is ended after so many rounds on purpose
        network.fit(X, y / size)
    numbers = sum(weights.size for weights in (*network.coefs_, *network.intercepts_))
    return lambda table: size * network.predict((table.columns - mean) / spread), numbers


def _train_process(tables: Sequence[_Features], seed: int) -> tuple[Predict, int]:
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

    def gather(samples: int) -> tuple[Array, Array, Array, Array, float]:
        return _gather(tables, max(samples // len(tables), 2))

    few, y, _, _, size = gather(SCALE_SAMPLES)
    kernel: Any = ConstantKernel() * RBF(np.full(few.shape[1], 3.0), (0.1, 1e4)) + WhiteKernel(1e-3, (1e-6, 1.0))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        scaled = GaussianProcessRegressor(kernel, random_state=seed).fit(few, y / size)
    X, y, mean, spread, size = gather(PROCESS_SAMPLES)
    process = GaussianProcessRegressor(scaled.kernel_, optimizer=None).fit(X, y / size)
    return lambda table: size * process.predict((table.columns - mean) / spread), len(y) + X.shape[1] + 2


def find_carriers(fit: Fit, seed: int) -> dict[str, float]:
    """The share of the residual of a fit that each of `GROUPS` carries, the largest first; those beyond `CARRIES`."""
    from scipy.integrate import cumulative_trapezoid
    from sklearn.ensemble import HistGradientBoostingRegressor
    from threadpoolctl import threadpool_limits

    tables = []
    for record, modelled in zip(fit.records, fit.whole_forces, strict=True):
        energy = cumulative_trapezoid(modelled, record.displacement, initial=0.0)
        further = {"energy": energy, "time": record.time - record.time[0]}
        tables.append(_Features.of(record.replace(note="residual", force=record.force - modelled), further))
    order = np.random.default_rng(seed).permutation(len(tables))
    if len(order) < PARTS:
        return {}

    def error(names: Sequence[str]) -> float:
        chosen, errors = [table.only(names) for table in tables], []
        for k in range(PARTS):
            held = order[k::PARTS]
            X, y, mean, spread, size = _gather([chosen[i] for i in np.setdiff1d(order, held)], SAMPLES)
            trees = HistGradientBoostingRegressor(
                max_iter=80, max_leaf_nodes=16, min_samples_leaf=60, random_state=seed
            )
            trees.fit(X, y / size)
            for table in (chosen[i] for i in held):
                at = table.evenly(SAMPLES)
                rest = table.force[at] - size * trees.predict((table.columns[at] - mean) / spread)
                errors.append(float(np.mean(np.abs(rest))))
        return float(np.mean(errors))

    whole = float(np.mean([np.mean(np.abs(t.force[t.moving])) for t in tables]))
    # a tree takes milliseconds here; threads that share the cores with another process wait far longer for one another
    with threadpool_limits(limits=1):
        without = error(USUAL)
        errors = {group: error((*USUAL, *members)) for group, members in GROUPS.items()}
    shares = {group: (without - of_group) / max(whole, 1e-300) for group, of_group in errors.items()}
    ranked = sorted(shares.items(), key=lambda pair: -pair[1])
    return {group: share for group, share in ranked if share >= CARRIES}
