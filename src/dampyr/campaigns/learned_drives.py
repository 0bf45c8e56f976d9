"""Drives that were learned, from one campaign to the next: a file each in ``learned-drives`` beside the ``rig.toml``.

A file is for one wanted drive (displacement, voltage, period) on one rig (its name, actuator, table, encoder and supply) with
one specimen; what of these differs gives another file. A file that cannot be read is renamed, with a warning, and learning
begins without it.
"""

from __future__ import annotations

import hashlib
import json
import warnings
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from dampyr.atomic_write import write_whole
from dampyr.campaigns.learning import Array, Tracking
from dampyr.campaigns.recorded_tests import set_aside
from dampyr.errors import DampyrWarning, FileError
from dampyr.rig import Drive, RigSettings

FOLDER = "learned-drives"
FORMAT = 1
PARTS = ("actuator", "table", "encoder", "supply")  # tables of a rig.toml on which the motion depends
NANO = 1e-9  # m and V: drives that differ by less are the same
DIGITS = 10  # of a set point: 1e-10 m, where a count is 5e-6 m


@dataclass(frozen=True, eq=False)
class LearnedDrive:
    """The best set points (n,) [m] for a wanted drive, with what they have achieved, and when (UTC, ISO 8601)."""

    key: str
    words: str
    set_points: Array
    achieved: Tracking
    time: str

    @property
    def origin(self) -> str:
        """Where a drive that begins with it comes from, in words."""
        return f"the drive learned at {self.time}, with {100 * self.achieved.error:.2g} % then"


def drive_key(wanted: Drive, rig: RigSettings, groups: Mapping[str, str]) -> str:
    """What a learned drive is for: a hash of the wanted drive, of the rig as far as it moves the table, and of the specimen.

    ``groups`` names the specimen of the run as its records do.
    """
    parts = {name: asdict(getattr(rig, name)) for name in PARTS}
    specimen = {"name": groups.get("specimen", ""), "card": rig.specimen.card}
    text = json.dumps([wanted.period, rig.name, rig.wires.drive, parts, specimen], sort_keys=True, default=str)
    hashed = hashlib.sha256(text.encode())
    for values in (wanted.displacement, wanted.voltage):
        hashed.update(np.round(values / NANO).astype("<i8").tobytes())
    return hashed.hexdigest()[:16]


def path_of(folder: Path, kind: str, key: str) -> Path:
    """The file of a learned drive."""
    return folder / f"{kind}-{key}.json"


def load_learned(folder: Path, kind: str, key: str, wanted: Drive) -> LearnedDrive | None:
    """The learned drive for ``key``; None where there is none. A broken file is renamed, with a warning."""
    path = path_of(folder, kind, key)
    try:
        text = path.read_text("utf-8")
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (OSError, UnicodeDecodeError) as problem:
        _rename_broken(path, str(problem))
        return None
    try:
        return _parse(json.loads(text), key, wanted)
    except (KeyError, TypeError, ValueError) as problem:
        _rename_broken(path, f"{type(problem).__name__}: {problem}")
        return None


def _parse(document: Any, key: str, wanted: Drive) -> LearnedDrive:
    """The drive in a file; KeyError, TypeError or ValueError where there is none, or one for something else."""
    if document["format"] != FORMAT or document["key"] != key:
        raise ValueError(f"format {document['format']} for {document['key']}, and not format {FORMAT} for {key}")
    points = np.asarray(document["set_points_m"], dtype=np.float64)
    if points.shape != wanted.displacement.shape or not np.all(np.isfinite(points)):
        raise ValueError(
            f"set_points_m has the shape {points.shape}, or is not finite; {wanted.displacement.shape} is wanted"
        )
    if not np.allclose(points[[0, -1]], wanted.displacement[[0, -1]], rtol=0.0, atol=NANO):
        raise ValueError("set_points_m does not begin and end where the table rests")
    achieved = Tracking(float(document["error"]), float(document["rms"]))
    if not 0.0 <= achieved.rms <= achieved.error < np.inf:
        raise ValueError(f"error = {achieved.error}, rms = {achieved.rms}")
    return LearnedDrive(key, str(document["words"]), points, achieved, str(document["time"]))


def _rename_broken(path: Path, why: str) -> None:
    """Rename a file that does not hold a learned drive, and warn."""
    try:
        renamed = f"it is {set_aside(path).name} now"
    except OSError as problem:
        renamed = f"and cannot be renamed ({problem.strerror or problem})"
    warnings.warn(
        f"{path} holds no learned drive ({why}); {renamed}, and learning begins anew", DampyrWarning, stacklevel=4
    )


def save_learned(folder: Path, kind: str, learned: LearnedDrive, wanted: Drive) -> Path:
    """Write a learned drive whole or not at all; :class:`~dampyr.errors.FileError` where the disk takes nothing."""
    path = path_of(folder, kind, learned.key)
    document = {
        "format": FORMAT, "key": learned.key, "words": learned.words, "time": learned.time,
        "error": learned.achieved.error, "rms": learned.achieved.rms, "period_s": wanted.period,
        "wanted_m": _rounded(wanted.displacement), "set_points_m": _rounded(learned.set_points),
        "voltage_V": _rounded(wanted.voltage),
    }  # fmt: skip
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_whole(path, json.dumps(document))
    except OSError as problem:
        raise FileError(
            path, f"cannot be written ({problem.strerror or problem}); make room, or make it writable"
        ) from problem
    return path


def _rounded(values: Array) -> list[float]:
    return [round(float(value), DIGITS) for value in values]
