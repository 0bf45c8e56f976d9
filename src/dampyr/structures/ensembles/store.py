"""Store of an ensemble's peaks with the labels of their axes: in memory, or in a file that survives a kill and is resumed."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dampyr.atomic_write import whole_file
from dampyr.errors import FileError, InputError
from dampyr.findings import Finding
from dampyr.ground_motions import GroundMotion
from dampyr.ground_motions.intensity_measures import sa
from dampyr.input_kinds import NO_INPUT
from dampyr.origin import NOT_STATED, Origin, combined
from dampyr.records.files.self_contained import check_contained
from dampyr.structures.control_laws import describe_law, is_control_law
from dampyr.structures.ensembles.ensemble_accuracy import outside_sentence
from dampyr.structures.ensembles.ensemble_batches import BIASED, Shard
from dampyr.structures.ensembles.ensemble_grid import AXES, Cases
from dampyr.structures.ensembles.peak_limits import UNITS
from dampyr.structures.sites import calibrated_displacements, places_and_dampers

Array = NDArray[np.float64]
FORMAT = "dampyr ensemble 1"
MAPPED = 2**28  # bytes of a quantity from which it stays in the file: what a laptop's memory holds several times
TRUNCATION = {
    "truncation": "truncation_error",
    "truncation_acceleration": "truncation_error_acceleration",
    "truncation_force": "truncation_error_force",
}
# Of a shard, in the order of the columns of a file, of which older files have fewer.
DIAGNOSTICS = (
    *("error", "judged", "unbounded", "general", "moving", "unconverged"),
    *TRUNCATION,
    *("calibrated", "beyond", "beyond_times"),
    *("judged_under_laws", "flipped"),
    *(f"{part}_{quantity}" for part in ("bias", "square") for quantity in BIASED),
)
BARE, WITH_DAMPER = "no damper", "with damper"  # the second where the damper has no input that names its case
SA_DAMPING = 0.05  # ratio to critical, that of published spectra
UNIT_OF = {"voltage": "V", "current": "A", NO_INPUT: ""}
ALONG = {
    "displacement": "floor",
    "drift": "storey",
    "acceleration": "floor",
    "force": "site",
    "stroke": "site",
    "energy": "site",
}


@dataclass(frozen=True, eq=False)
class Labels:
    """Labels of each axis. ``sa`` is the pseudo-acceleration (building, motion) [m/s2] of each unscaled motion at the
    building's first ``period`` [s] and 5 % damping, ``pga`` (motion,) its peak [m/s2]. ``inputs`` are NaN where there is no
    constant one, ``input_name`` says in words what there is. ``calibrated`` are the displacements [m] that dampers were
    calibrated on, rising."""

    building: list[str]
    damper: list[str]
    inputs: list[float]
    motion: list[str]
    scale: list[float]
    kind: str
    period: list[float]
    pga: list[float]
    sa: list[list[float]]
    input_name: list[str] = field(default_factory=list)
    damper_origin: str = NOT_STATED.kind  # as JSON; of files of dampyr up to 0.3.0 the kind alone
    calibrated: list[float] = field(default_factory=list)

    @classmethod
    def of(cls, what: Cases) -> Labels:
        """The labels of checked cases."""
        several = sum(bool(placed) for placed in what.placements) > 1
        damper_names = [
            BARE if not placed else f"damper {k}" if several else "damper"
            for k, placed in enumerate(what.placements, 1)
        ]
        lowest = [float(building.frequencies[0]) for building in what.buildings]
        periods = [1.0 / frequency if frequency > 0 else math.inf for frequency in lowest]  # of a building that floats
        return cls(
            [building.name for building in what.buildings],
            damper_names,
            [u if isinstance(u, float) else float("nan") for u in what.inputs],
            [motion.name for motion in what.motions],
            what.scales.tolist(),
            what.kind,
            periods,
            [motion.pga for motion in what.motions],
            [[_sa(motion, period) for motion in what.motions] for period in periods],
            [_input_name(u, UNIT_OF[what.kind]) for u in what.inputs],
            combined(damper.origin for placed in what.placements for _, damper in places_and_dampers(placed)).as_json(),
            sorted(
                {
                    limit
                    for placed in what.placements
                    for limit in calibrated_displacements(placed)
                    if np.isfinite(limit)
                }
            ),
        )

    @property
    def shape(self) -> tuple[int, int, int, int, int]:
        """How many of each, in the order of `AXES`."""
        return len(self.building), len(self.damper), len(self.inputs), len(self.motion), len(self.scale)

    def text(self) -> str:
        """As JSON, for a file; floats come back to the last bit."""
        return json.dumps({axis.name: getattr(self, axis.name) for axis in fields(self)})

    @classmethod
    def read(cls, text: str) -> Labels:
        """From `text`."""
        return cls(**json.loads(text))

    def dataset(self, values: Mapping[str, ArrayLike], attributes: Mapping[str, Any]) -> Any:
        """The labelled peaks; ``values`` quantity -> (lines, scales, width)."""
        import xarray

        data = {
            quantity: (
                (*AXES, ALONG[quantity]),
                np.reshape(array, (*self.shape, np.shape(array)[-1])),
                {"units": UNITS[quantity]},
            )
            for quantity, array in values.items()
        }
        coordinates = self._coordinates()
        for dims, array, _ in data.values():
            coordinates[dims[-1]] = np.arange(1, array.shape[-1] + 1)
        return xarray.Dataset(data, coords=coordinates, attrs={**attributes, "damper_origin": self.damper_origin})

    def _coordinates(self) -> dict[str, Any]:
        acceleration = {"units": "m/s^2"}
        return {
            "building_name": ("building", self.building),
            "period": ("building", np.array(self.period), {"units": "s"}),
            "damper_name": ("damper", self.damper),
            "input": ("input", np.array(self.inputs), {"units": UNIT_OF[self.kind]}),
            "input_name": ("input", self.input_name or [_input_name(u, UNIT_OF[self.kind]) for u in self.inputs]),
            "motion_name": ("motion", self.motion),
            "pga": ("motion", np.array(self.pga), acceleration),
            "sa": (("building", "motion"), np.array(self.sa), acceleration | {"damping": SA_DAMPING}),
            "scale": np.array(self.scale),
        }


def _sa(motion: GroundMotion, period: float) -> float:
    """Not a number where the spectrum does not reach, at periods far below the motion's step or without end."""
    try:
        return sa(motion, period, SA_DAMPING)
    except InputError:
        return float("nan")


def _input_name(u: Any, unit: str) -> str:
    """A number with its unit, a law by its name and settings, nothing for the bare building."""
    if is_control_law(u):
        return describe_law(u, unit)
    return "" if u is None or math.isnan(u) else f"{u:g} {unit}"


class Store:
    """The values of all lines; with a path, an HDF5 file in which each shard is marked done once it is on the disk."""

    def __init__(self, what: Cases, path: str | Path | None) -> None:
        self.what, self.shards = what, what.shards()
        self.labels = Labels.of(what)
        self.file: Any = None
        self.path = None if path is None else Path(path)
        if self.path is None:
            self.values: dict[str, Any] = {q: np.full(self._shape(q), np.nan) for q in what.quantities}
        else:
            self._open(self.path)
        self.diagnostics = np.zeros((self.shards, len(DIAGNOSTICS))) if self.file is None else self.file["told"][:]

    def _shape(self, quantity: str) -> tuple[int, int, int]:
        return self.what.lines, len(self.what.scales), self.what.width(quantity)

    def _open(self, path: Path) -> None:
        import h5py

        try:
            if not path.exists():
                with whole_file(path) as temporary, h5py.File(temporary, "w") as file:
                    self._prepare(file)
            with h5py.File(path, "r") as file:
                check_contained(path, file)
            self.file = h5py.File(path, "r+")
        except OSError as error:
            raise FileError(path, f"cannot be opened as an ensemble ({error}); choose another file") from None
        if self.file.attrs.get("digest") != self.what.digest:
            self.file.close()
            raise FileError(
                path, f"holds another ensemble{self.what.other_version}; choose another file, or remove this one"
            )
        self.shards = int(self.file.attrs["shards"])  # as the file was begun
        self.values = {q: self.file[q] for q in self.what.quantities}
        self.done = self.file["done"]

    def _prepare(self, file: Any) -> None:
        for quantity in self.what.quantities:
            allocate_dataset(file, quantity, self._shape(quantity))
        file["done"] = np.zeros(self.shards, dtype=bool)
        file["told"] = np.zeros((self.shards, len(DIAGNOSTICS)))
        describe(file, self.what, self.labels)
        file.attrs["shards"] = self.shards

    def missing(self) -> list[int]:
        """The shards that are still to do."""
        if self.file is None:
            return list(range(self.shards))
        return [int(k) for k in np.flatnonzero(~self.done[:])]

    def put(self, shard: Shard) -> None:
        """Store a shard; it counts as done only after its values are written."""
        for quantity, values in shard.values.items():
            self.values[quantity][shard.lines.start : shard.lines.stop] = values
        self.diagnostics[shard.number] = [getattr(shard, name) for name in DIAGNOSTICS[: self.diagnostics.shape[1]]]
        if self.file is not None:
            self.file["told"][shard.number] = self.diagnostics[shard.number]
            self.file.flush()
            self.done[shard.number] = True
            self.file.flush()

    def close(self) -> None:
        """Close the file."""
        if self.file is not None:
            self.values = {q: values_of(values) for q, values in self.values.items()} if not self.missing() else {}
            self.file.close()

    def dataset(self) -> Any:
        """All values with labels, and the measured errors."""
        what = self.what
        measured = attributes(
            self.diagnostics,
            what.accuracy,
            what.precision,
            what.size,
            what.after,
            what.findings,
            self.labels.calibrated,
        )
        return self.labels.dataset(dict(self.values), measured)


def allocate_dataset(file: Any, quantity: str, shape: tuple[int, ...]) -> Any:
    """A dataset of NaN that lies in one piece at its full length from the beginning: a kill can only leave NaN in it."""
    import h5py

    how = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    how.set_layout(h5py.h5d.CONTIGUOUS)
    how.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    how.set_fill_value(np.array(np.nan))
    return file.create_dataset(quantity, shape, "f8", dcpl=how)


def values_of(dataset: Any) -> Array:
    """The values of a dataset: in memory, or, where they are many, mapped from the file and read on access."""
    if dataset.nbytes < MAPPED or (offset := dataset.id.get_offset()) is None:
        return np.asarray(dataset[:])
    return np.memmap(dataset.file.filename, dataset.dtype, "r", offset, dataset.shape)


def describe(file: Any, what: Cases, labels: Labels) -> None:
    """Write the description of an ensemble into its file."""
    file.attrs["format"] = FORMAT
    file.attrs["digest"] = what.digest
    file["labels"] = labels.text()  # no attribute: those end at 64 KiB
    file.attrs["quantities"] = list(what.quantities)
    file.attrs["accuracy"] = what.accuracy
    file.attrs["precision"] = what.precision
    if what.after:
        file.attrs["after"] = what.after
    if what.findings:
        file["findings"] = [
            json.dumps(finding.as_dict()) for finding in what.findings
        ]  # no attribute: those end at 64 KiB


def attributes(
    diagnostics: Array,
    accuracy: str,
    precision: int,
    size: int,
    after: float = 0.0,
    findings: Iterable[Finding] = (),
    calibrated: Sequence[float] = (),
) -> dict[str, Any]:
    """Errors and counts, from the rows of `DIAGNOSTICS` of all shards; ``after_s`` where the motions have a rest, ``findings``
    as JSON where the dampers have some, ``outside`` where a stroke leaves the displacements [m] that they were ``calibrated``
    on."""
    of_dampers = [json.dumps(finding.as_dict()) for finding in findings]
    sums = dict(zip(DIAGNOSTICS, diagnostics.sum(axis=0)))
    largest = dict(zip(DIAGNOSTICS, diagnostics.max(axis=0, initial=0.0)))
    beyond, with_limits = int(sums.get("beyond", 0)), int(sums.get("calibrated", 0))
    outside = outside_sentence(beyond, with_limits, float(largest.get("beyond_times", 0.0)), calibrated)
    return {
        "error_estimate": float(largest["error"]),
        "judged": int(sums["judged"]),
        "unbounded": int(sums["unbounded"]),
        "one_by_one": int(sums["general"]),
        "accuracy": accuracy,
        "precision_bits": precision,
        "cases": size,
        **({"error_estimate_moving": float(largest["moving"])} if "moving" in largest else {}),
        **({"unconverged": int(sums["unconverged"])} if sums.get("unconverged") else {}),
        **({"after_s": after} if after else {}),
        **{
            attribute: float(largest[name])
            for name, attribute in TRUNCATION.items()
            if name in largest and np.max(diagnostics[:, DIAGNOSTICS.index(name)], initial=-1.0) >= 0.0
        },
        **_under_laws(sums),
        **({"findings": of_dampers} if of_dampers else {}),
        **({"outside": outside} if outside else {}),
    }


def _under_laws(sums: Mapping[str, float]) -> dict[str, Any]:
    """What half the step changes under control laws, in the cases that were judged; nothing where there were none."""
    judged = int(sums.get("judged_under_laws", 0))
    if not judged:
        return {}
    told: dict[str, Any] = {"judged_under_laws": judged, "changed_under_laws": int(sums["flipped"])}
    for quantity in BIASED:
        mean, square = (sums[f"{part}_{quantity}"] / judged for part in ("bias", "square"))
        told[f"change_of_mean_{quantity}"] = float(mean)
        told[f"error_of_mean_{quantity}"] = 2.0 * math.sqrt(
            max(square - mean**2, 0.0) / judged
        )  # twice the standard error
    return told


def read_dataset(path: str | Path) -> Any:
    """The peaks in the file of an ensemble, the same ``xarray.Dataset`` that it gave; see `read_ensemble`.

    Raises :class:`~dampyr.errors.FileError` where the file is not an ensemble, or is not finished.
    """
    import h5py

    path = Path(path)
    try:
        file = h5py.File(path, "r")
    except OSError as error:
        why = "is not there" if not path.exists() else f"cannot be read as an ensemble ({error})"
        raise FileError(path, f"{why}; give a file that ensemble(..., out=) wrote") from None
    with file:
        check_contained(path, file)
        if file.attrs.get("format") != FORMAT:
            raise FileError(path, f"is not {FORMAT!r} but {file.attrs.get('format')!r}; give a file that dampyr wrote")
        done = file["done"][:]
        if not done.all():
            raise FileError(
                path,
                f"is not finished: {done.sum()} of {done.size} shards are there; run the same ensemble again with it",
            )
        labels = Labels.read(file["labels"].asstr()[()])
        values = {quantity: values_of(file[quantity]) for quantity in file.attrs["quantities"]}
        return labels.dataset(values, attributes(file["told"][:], *made_with(file, labels)))


def made_with(file: Any, labels: Labels) -> tuple[str, int, int, float, list[Finding], list[float]]:
    """The arguments of `attributes` after the first, of an ensemble or of the whole that a part belongs to."""
    attrs, size = file.attrs, int(np.prod(labels.shape))
    findings = list(map(finding_of, file["findings"].asstr()[:])) if "findings" in file else []
    after, precision = float(attrs.get("after", 0.0)), int(attrs["precision"])
    return str(attrs["accuracy"]), precision, size, after, findings, labels.calibrated


def dataset_of(result: Any) -> Any:
    """The dataset of the result of an ensemble; a dataset is one already."""
    return getattr(result, "dataset", result)


def origin_of(dataset: Any) -> Origin:
    """The origin of the dampers of an ensemble, not stated in files of before it was written."""
    return Origin.from_json(dataset.attrs.get("damper_origin", NOT_STATED.kind))


def finding_of(text: str) -> Finding:
    """A finding as a file of an ensemble or its ``attrs`` have it: JSON, up to 0.3.0 a sentence."""
    return Finding.from_dict(json.loads(text)) if text.startswith("{") else Finding("doubt", text)


def progress_of(path: str | Path) -> tuple[int, int]:
    """How many shards of an ensemble's file are done, and of how many; (0, 0) where there is no such file yet."""
    import h5py

    if not Path(path).exists():
        return 0, 0
    try:
        with h5py.File(path, "r") as file:
            check_contained(Path(path), file)
            done = file["done"][:]
    except (OSError, KeyError):
        return 0, 0
    return int(done.sum()), int(done.size)
