"""SAC of IRIS, binary: a header of 632 bytes, then samples of 4; one component a file, in the unit that is declared.

The header's 70 reals, 40 integers and 24 words of 8 characters say the step (``DELTA``), the number of samples (``NPTS``), the
least and the largest sample (``DEPMIN``, ``DEPMAX``) and what they are (``IDEP``), but no unit: by the book an acceleration is
in nm/s2, and hardly any file is. ``--motion-unit`` declares it, or ``--factor acceleration='2.1e-6 m/s^2'`` what a count is.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from dampyr import channel_columns
from dampyr.channel_columns import OF_TEXTS, ColumnTable
from dampyr.errors import FileError
from dampyr.ground_motions.motion import GroundMotion
from dampyr.ground_motions.motion_options import ACCELERATION, MotionReadOptions
from dampyr.ground_motions.samples import motion_of

SUFFIXES = (".sac",)
TAKES_OPTIONS = True
TITLE = "SAC"
HEADER = 632  # bytes
VERSIONS = (6, 7)
NOTHING = -12345.0  # of a value that is not stated
REALS = {"DELTA": 0, "DEPMIN": 1, "DEPMAX": 2}  # their places among the reals
INTEGERS = {"NVHDR": 6, "NPTS": 9, "IFTYPE": 15, "IDEP": 16, "LEVEN": 35}
WORDS = {"KSTNM": 440, "KCMPNM": 600, "KNETWK": 608}  # bytes at which 8 characters begin
TIME_SERIES = 1  # of IFTYPE
NOT_ACCELERATION = {6: "a displacement", 7: "a velocity"}  # of IDEP
PEAK_TOLERANCE = 1e-4  # relative: DEPMIN and DEPMAX are of single precision


def read(
    path: Path, units: str | None = None, dt: float | None = None, options: MotionReadOptions | None = None
) -> GroundMotion:
    """The ground motion in a SAC file."""
    content = path.read_bytes()
    order = next((order for order in "<>" if len(content) > HEADER and _version(content, order) in VERSIONS), None)
    if order is None:
        raise FileError(
            path,
            f"is not a binary SAC file: none of its byte orders gives the version of its header as "
            f"{VERSIONS[0]} or {VERSIONS[1]}; write it so, such as `write` of SAC does, or as columns of text",
        )
    reals = np.frombuffer(content, f"{order}f4", 70)
    integers = np.frombuffer(content, f"{order}i4", 40, 280)
    real = {name: float(reals[place]) for name, place in REALS.items()}
    integer = {name: int(integers[place]) for name, place in INTEGERS.items()}
    words = {name: content[at : at + 8].decode("latin-1").strip("\0 ") for name, at in WORDS.items()}
    count = integer["NPTS"]
    _check(path, content, real, integer, dt)
    values = np.frombuffer(content, f"{order}f4", count, HEADER).astype(float)
    for name, extreme in (("DEPMIN", float(values.min())), ("DEPMAX", float(values.max()))):
        if real[name] != NOTHING and abs(extreme - real[name]) > PEAK_TOLERANCE * float(np.abs(values).max()):
            raise FileError(
                path,
                f"its header says {name} = {real[name]:.6g} and the samples have {extreme:.6g}; the file was changed or "
                "misread, so fetch it again",
            )
    # DELTA is of single precision: the shortest decimal that it can be is the step
    step = float(str(np.float32(real["DELTA"])))
    return counted_motion(
        path,
        values,
        step,
        units,
        options,
        f"SAC, {'.'.join(filter(None, (words['KNETWK'], words['KSTNM'], words['KCMPNM'])))}",
    )


def counted_motion(
    path: Path, values: np.ndarray, step: float, units: str | None, options: MotionReadOptions | None, source: str
) -> GroundMotion:
    """The ground motion of samples in a unit, or of a factor, that a person declares."""
    request = options or MotionReadOptions()
    reason = "the samples are no columns"
    request.refuse(path, columns=reason, **dict.fromkeys(OF_TEXTS, reason))
    request = replace(request, units={**request.units, **({ACCELERATION: units} if units else {})})
    if not (request.units.get(ACCELERATION) or request.factor(ACCELERATION)[1]):
        raise FileError(
            path,
            "names no unit of its samples; declare it, such as --motion-unit m/s^2 or units='m/s^2', or what a count is, "
            "such as --factor acceleration='2.1e-6 m/s^2' or factors={'acceleration': '2.1e-6 m/s^2'}",
        )
    table = ColumnTable((ACCELERATION,), ("",), values[:, None])
    in_si, notes = channel_columns.in_si(path, table, ACCELERATION, 0, request)
    return replace(motion_of(path, in_si, step, "m/s^2", source=source), history=notes)


def _version(content: bytes, order: str) -> int:
    return int(np.frombuffer(content, f"{order}i4", 1, 280 + 4 * INTEGERS["NVHDR"])[0])


def _check(path: Path, content: bytes, real: dict[str, float], integer: dict[str, int], dt: float | None) -> None:
    count = integer["NPTS"]
    if integer["IFTYPE"] != TIME_SERIES or not integer["LEVEN"]:
        raise FileError(
            path, "is no series of even time steps (IFTYPE 1 and LEVEN); write it so, or as columns of text"
        )
    if integer["IDEP"] in NOT_ACCELERATION:
        raise FileError(
            path, f"holds {NOT_ACCELERATION[integer['IDEP']]} (IDEP = {integer['IDEP']}); give its acceleration"
        )
    if count < 2 or len(content) < HEADER + 4 * count:
        raise FileError(
            path,
            f"its header says NPTS = {count} and {(len(content) - HEADER) // 4} samples follow; the file was cut, so fetch it "
            "again",
        )
    if not real["DELTA"] > 0:
        raise FileError(
            path, f"its step DELTA is {real['DELTA']:g} s; it must be greater than 0, so fetch the file again"
        )
    if dt is not None and abs(dt - real["DELTA"]) > 1e-6 * real["DELTA"]:
        raise FileError(path, f"dt = {dt:g} s contradicts its header's DELTA = {real['DELTA']:g} s; leave dt out")
