"""ESM and ITACA (DYNA 1.2): lines ``KEY: value``, then accelerations, one a line; one component a file.

``UNITS`` names the unit, ``SAMPLING_INTERVAL_S`` the step, ``NDATA`` how many samples there are and ``PGA_CM/S^2`` their peak.
Files of velocity, displacement or spectra (``DATA_TYPE``) are refused.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from dampyr.errors import FileError
from dampyr.ground_motions.channels import MotionChannel, StatedPeak, unit_of

TITLE = "ESM"
SUFFIXES = (".asc",)
SIGNATURE = "'EVENT_NAME:' at the head of line 1"
LINE = re.compile(r"([A-Z][A-Z0-9_/^]*)\s*:(.*)")


def recognises(lines: Sequence[str]) -> bool:
    """Whether the first lines of a file are those of DYNA."""
    return bool(lines) and lines[0].startswith("EVENT_NAME:")


def channels(path: Path, lines: Sequence[str]) -> list[MotionChannel]:
    """The one component of the file."""
    matches = [LINE.match(line) for line in lines]
    last = max(number for number, match in enumerate(matches) if match)
    header = {match[1]: match[2].strip() for match in matches if match}
    kind = header.get("DATA_TYPE", "ACCELERATION").upper()
    if kind != "ACCELERATION":
        raise FileError(path, f"holds {kind.lower()} (DATA_TYPE); fetch the file of the acceleration")
    try:
        values = np.array([float(line) for line in lines[last + 1 :] if line.strip()])
        step, count = float(header["SAMPLING_INTERVAL_S"]), int(header["NDATA"])
    except KeyError as problem:
        raise FileError(path, f"the header has no {problem.args[0]}; fetch the file again") from None
    except ValueError as problem:
        raise FileError(path, f"holds what is not a number ({problem}); fetch the file again") from None
    if len(values) != count:
        raise FileError(
            path,
            f"the header says NDATA = {count} but {len(values)} values follow; the file was cut, so fetch it again",
        )
    station, stream = header.get("STATION_CODE", ""), header.get("STREAM", "")
    # the header's peak is named after its unit, as in PGA_CM/S^2
    peak = next((header[key] for key in header if key.startswith("PGA_") and header[key]), None)
    name = " ".join(part for part in (header.get("NETWORK", ""), station, header.get("LOCATION", "")) if part)
    source = f"ESM, station {name}, {stream}, event {header.get('EVENT_NAME', '')} {header.get('EVENT_ID', '')}".strip()
    return [
        MotionChannel(
            stream, values, step, unit_of(path, header.get("UNITS", "")), source,
            f"{name} {header.get('EVENT_ID', '')}".strip(), StatedPeak.of(peak) if peak else None,
        )
    ]  # fmt: skip
