"""Small files in the layouts of networks of accelerographs, with invented stations and values.

Each is written by the layout that its format's module states, with what trips readers in it: fields that touch, an offset, a
step of more digits than its line has, several components, velocities behind the accelerations, Latin-1.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def shaking(n: int = 41, seed: int = 1, peak: float = 100.0) -> Array:
    """Samples with the given peak, rounded to three decimals."""
    values = np.random.default_rng(seed).standard_normal(n) * np.hanning(n)
    return np.round(values * (peak / np.abs(values).max()), 3)


def _rows(values: Sequence[float] | Array, form: str, per_line: int) -> list[str]:
    """Fields one after the other, ``per_line`` a line; a zero before a decimal point is left out as Fortran does."""
    fields = [_field(value, form) for value in values]
    return ["".join(fields[k : k + per_line]) for k in range(0, len(fields), per_line)]


def _field(value: float, form: str) -> str:
    text = form.format(value)
    return text if len(text) <= int(form.split(":")[1].split(".")[0].rstrip("de}")) else text.replace("0.", ".", 1)


def _save(path: Path, lines: Sequence[str], end: str = "\n") -> Path:
    path.write_bytes((end.join(lines) + end).encode("latin-1"))
    return path


def knet(
    path: Path, counts: Array, peak: float, direction: str = "E-W", rate: int = 100, station: str = "XXX001"
) -> Path:
    """K-NET, 3920 gal over 6182761 counts."""
    header = {
        "Origin Time": "2001/02/03 04:05:06", "Lat.": "0.0", "Long.": "0.0", "Depth. (km)": "7", "Mag.": "5.0",
        "Station Code": station, "Station Lat.": "0.0", "Station Long.": "0.0", "Station Height(m)": "0",
        "Record Time": "2001/02/03 04:05:21", "Sampling Freq(Hz)": f"{rate}Hz", "Duration Time(s)": f"{len(counts) // rate}",
        "Dir.": direction, "Scale Factor": "3920(gal)/6182761", "Max. Acc. (gal)": f"{peak:.3f}",
        "Last Correction": "2001/02/03 04:00:00", "Memo.": "",
    }  # fmt: skip
    return _save(path, [f"{key:<18}{value}" for key, value in header.items()] + _rows(counts, "{:9.0f}", 8))


def esm(path: Path, values: Array, stream: str = "HNE", peak: float | None = None, **changes: str) -> Path:
    """ESM, DYNA 1.2, in cm/s^2."""
    largest = values[np.argmax(np.abs(values))] if peak is None else peak
    header = {
        "EVENT_NAME": "NOWHERE", "EVENT_ID": "XX-2001-0001", "NETWORK": "XX", "STATION_CODE": "ABC", "LOCATION": "",
        "SAMPLING_INTERVAL_S": "0.005000", "NDATA": str(len(values)), "STREAM": stream, "UNITS": "cm/s^2",
        "PGA_CM/S^2": f"{largest:.6f}", "DATA_TYPE": "ACCELERATION", "USER1": "", "USER5": "",
    }  # fmt: skip
    header.update(changes)
    return _save(path, [f"{key}: {value}" for key, value in header.items()] + [f"{value:.6f}" for value in values])


def smc(
    path: Path, values: Array, rate: float = 200.0, kind: str = "2 CORRECTED ACCELEROGRAM", comments: int = 2
) -> Path:
    """SMC: values as 1.2714E+1, ten columns each, so that negative ones touch the one before."""
    integers, reals = np.full(48, -32768), np.full(50, 1.7e38)
    integers[[15, 16]] = comments, len(values)
    reals[[1, 29, 31]] = rate, values.max(), values.min()
    texts = [
        kind, "*", "A001A", "     2001   2  3   0405 Nowhere", "Moment Mag= 5.0", "station = Field Seven   component=    133",
        "epicentral dist =     63.0       pk     =   -222.5", "inst type=SMA-1 data source = none", "*", "*", "*",
    ]  # fmt: skip
    data = []
    for value in values:
        mantissa, exponent = f"{value:.4E}".split("E")
        data.append(f"{mantissa}E{int(exponent):+d}".rjust(10))
    return _save(
        path,
        [f"{text:<80}" for text in texts]
        + _rows(integers, "{:10d}", 8)
        + _rows(reals, "{:15.7E}", 5)
        + ["|a comment"] * comments
        + ["".join(data[k : k + 8]) for k in range(0, len(data), 8)],
    )


def cosmos(
    path: Path, channels: dict[str, Array], dt: float = 0.005, unit: str = "cm/sec2(04)", kind: str = "acceleration"
) -> Path:
    """COSMOS v1.20, one component after the other, each with its velocity behind it."""
    lines: list[str] = []
    for number, (name, values) in enumerate(channels.items(), start=1):
        for what in (kind, "velocity"):
            reals = np.full(100, -999.0)
            reals[[33, 63]] = dt, values[np.argmax(np.abs(values))]
            texts = ["Corrected acceleration    (Format v01.20 with 13 text lines) Src: none", *["text"] * 12]
            texts[4] = "Statn No: 01-00001  Code:XX-0001  Nowhere"
            texts[8] = f"Sta Chan   {number}: {name} (Rcrdr Chan  {number}) Location: roof"
            lines += texts
            lines += [
                " 100 Integer-header values follow on  10 lines, Format= (10I8)",
                *_rows([-999] * 100, "{:8d}", 10),
            ]
            lines += [" 100 Real-header values follow on  17 lines, Format= (6F13.6)", *_rows(reals, "{:13.6f}", 6)]
            lines += [
                '   2 Comment line(s) follow, each starting with a "|":',
                "| one",
                "| two: 7000 acceleration pts, units=g",
            ]
            lines += [f"{len(values):8d} {what} pts, approx   70 secs, units={unit},Format=(8F10.5)"]
            lines += [*_rows(values, "{:10.5f}", 8), "/&"]
    return _save(path, lines, "\r\n")


def csmip_v2(path: Path, channels: dict[str, Array], dt: float = 0.005) -> Path:
    """A corrected volume 2 of CSMIP, velocity and displacement behind each acceleration; (8f10.6), which touches at -100."""
    lines: list[str] = []
    for number, (name, values) in enumerate(channels.items(), start=1):
        peak = values[np.argmax(np.abs(values))]
        reals = np.zeros(100)
        reals[[60, 65]] = dt, peak
        texts = [f"Corrected accelerogram   00001-X0001-00000.01       Chan  {number}: {name}     from   "]
        texts += ["Uncorrected Accelerogram Data             Processed: 01/02/03, none"]
        texts += ["text"] * 15 + [f"Peak acceleration = {peak:9.3f}    cm/sec/sec  at   30.585   sec."] + ["text"] * 7
        integers = _rows([1] * 100, "{:5d}", 16)
        lines += (
            texts + integers + ["".join(f"{value:10.7f}"[:10] for value in reals[k : k + 8]) for k in range(0, 100, 8)]
        )
        for what, factor, unit in (("accel", 1.0, "cm/sec2"), ("veloc", 0.01, "cm/sec"), ("displ", 0.001, "cm")):
            lines += [
                f"{len(values):6d} points of {what} data equally spaced at  {dt:.3f} sec, in {unit}. (8f10.6)    "
            ]
            lines += _rows(factor * values, "{:10.5f}", 8)
        lines += ["/&"]
    return _save(path, lines)


def csmip_v1(path: Path, values: Array, rate: int = 200) -> Path:
    """An uncorrected volume 1 of CSMIP of equal steps, in g (8f9.6)."""
    peak = values[np.argmax(np.abs(values))]
    texts = ["Uncorrected Accelerogram Data             Processed: 01/02/03, none", *["text"] * 5, "Chan  1: 360 Deg"]
    texts += ["text"] * 4 + [
        f"Units of uncor data are sec and g .        Max  = {peak:6.3f} g , at  30.590 sec.",
        "text",
    ]
    lines = [*texts, *_rows([1] * 100, "{:5d}", 16), *_rows([0.0] * 66, "{:10.7f}", 8)]
    lines += [f"{len(values):6d} Accelerogram points at {rate} pts/sec in units of g .      Format: (8f9.6)  "]
    return _save(path, lines + _rows(values, "{:9.6f}", 8))


def volume_1(path: Path, channels: dict[str, tuple[Array, Array]], blank: str = "") -> Path:
    """An uncorrected volume 1 of pairs of time and g/10, in fields of 7 columns; ``blank`` begins each line of USC's."""
    lines: list[str] = []
    for number, (name, (time, values)) in enumerate(channels.items(), start=1):
        peak = 0.1 * values[np.argmax(np.abs(values))]
        lines += ["UNCORRECTED ACCELEROGRAM DATA              PROCESSED: 01/02/03, NONE", *["TEXT"] * 5]
        lines += [f"CHAN  {number}:  {name}", *["TEXT"] * 3, f"NO. OF POINTS =  {len(time)}  RECORD LENGTH = 1 SEC"]
        lines += [f"UNITS OF UNCOR ACCEL ARE SEC AND G/10.     MAX  = {peak:6.3f} G, AT  11.576 SEC.", "TEXT"]
        lines += [*_rows([1] * 100, "{:5d}", 16), *_rows([0.0] * 50, "{:10.3f}", 8)]
        pairs = np.column_stack([time, values]).ravel()
        lines += [blank + row for row in _rows(pairs, "{:7.3f}", 10)]
    return _save(path, lines)


def geonet(path: Path, channels: dict[str, Array], volume: int = 2, dt: float = 0.02) -> Path:
    """GeoNet's V1A or V2A, in mm/s2 with one decimal; fields of 8 columns that touch at -10000.0."""
    lines: list[str] = []
    for name, values in channels.items():
        integers, reals = np.zeros(40, dtype=int), np.zeros(60)
        integers[30 if volume == 1 else 33] = len(values)
        reals[[24, 25]] = (dt, 0.0) if volume == 1 else (0.005, dt)
        reals[30 if volume == 1 else 35] = values[np.argmax(np.abs(values))]
        kind = "Uncorrected" if volume == 1 else "Corrected"
        texts = [
            f"{kind} accelerogram 20010203_040506_ABC_20 GNS Science",
            "Site ABC  42 37 10S  173 03 13E",
            *["text"] * 10,
        ]
        texts += [f"Component {name}  Longitudinal Accelerometer Axis", "Acceleration:  peak  1.0 mm/s/s at  1.0 sec"]
        texts += ["text"] * 2
        numbers = [f"{value:8.4f}" if 0 < abs(value) < 1 else f"{value:8.1f}" for value in reals]
        lines += texts + _rows(integers, "{:8d}", 10) + ["".join(numbers[k : k + 10]) for k in range(0, 60, 10)]
        for factor in (1.0,) if volume == 1 else (1.0, 0.1, 0.01):
            lines += _rows(factor * values, "{:8.1f}", 10)
    return _save(path, lines)


def afad(path: Path, channels: dict[str, Array]) -> Path:
    """AFAD in its older form: Latin-1, CR LF, columns in gal."""
    first = next(iter(channels.values()))
    peaks = " ".join(f"({name}) {np.abs(values).max():.6f}" for name, values in channels.items())
    lines = [
        "STRONG GROUND MOTION RECORDS OF TURKIYE", "PLACE                   : KÜTAHYA", "STATION ID              : 0001",
        "RECORD TIME             : 20/07/2001 22:31:14.000000 (GMT)", f"NUMBER OF DATA          : {len(first)}",
        "SAMPLING INTERVAL (sec) : 0.01", f"RAW PGA VALUES (gal)    : {peaks}", "Copyright EARTHQUAKE DEPARTMENT",
        "DISASTER AND EMERGENCY MANAGEMENT PRESIDENCY", "       ".join(["", *channels]),
    ]  # fmt: skip
    rows = np.column_stack(list(channels.values()))
    return _save(path, lines + ["".join(f"{value:13.6f}" for value in row) for row in rows], "\r\n")
