"""Fingerprint of dampyr's numerical results: run on two checkouts, compare bit for bit.

::

    python tools/fingerprint.py --out before.json --root ../other-checkout
    python tools/fingerprint.py --out after.json
    python tools/fingerprint.py --compare before.json after.json

``--out`` imports dampyr from the sources of the checkout ``--root`` (default: the one that holds this script), runs four
sections and writes their results as JSON. Floats are written in hexadecimal (``float.hex``), so nothing is rounded:

``fits``
    The joint fits of four models (`MODELS`) to the 38 records of the published campaign: parameters and standard errors by
    label, the final cost, the number of iterations, whether the search converged.
``chapter_5``
    The building of chapter 5 under El Centro, without and with the published damper at several voltages, at the accuracies
    "strict" and "fast": the peaks of every floor and storey, and the sha256 of the force's history.
``ensemble``
    10,000 cases (2 buildings x 2 placements x 5 voltages x 500 scales) at the accuracies "fast" and "strict": for each array
    of peaks its shape, its sha256 and 20 values at even distances.
``campaign``
    Four tests on a simulated rig in this process, with a fixed seed: the sha256 of each channel of each record, where each
    test is a campaign of its own on a fresh rig; and of one campaign of all four the number of samples, the states of the
    tests in the journal and the kinds of its events. (Between two tests the rig reads on for as long as the file of the first
    takes to be finished, so on a busy machine the bits of the second depend on the disk.)

``--compare`` prints the leaves that differ, each with its difference relative to the larger of the two, then the largest
one by section; the exit status is 1 where anything differs. Versions of Python, numpy, scipy and numba are recorded; where
they differ a line says so, and it does not count as a difference.

Only calls of the public face are used (the journal is read as the SQLite file that it is), so the same script runs on old
and new sources. BLAS runs on one thread; ensembles run on one thread per core, and their numbers do not depend on it.
Results are reproducible on one machine with one set of packages; another processor may round differently.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
import os
import re
import sqlite3
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

CHECKOUT = Path(__file__).resolve().parent.parent
CAMPAIGN_FOLDER = "labcontrol-mr-damper"  # of the published campaign, inside the folder of data

# Name -> arguments of `dampyr.identification.fit` besides the records. The last one is the joint fit of `make bench`.
MODELS: dict[str, dict[str, Any]] = {
    "dahl": {"model": "dahl"},
    "bouc_wen": {"model": "bouc_wen"},
    "hyperbolic_tangent": {"model": "hyperbolic_tangent + spring"},
    "dahl + hyperbolic_tangent": {
        "model": "dahl + hyperbolic_tangent + spring + delay",
        "bandwidth": 8.0,
        "fixed": {"hyperbolic_tangent.c": 0.0, "hyperbolic_tangent.s": 0.0},
    },
}

VOLTAGES = (0.0, 0.8712, 1.98, 2.6, 3.212)  # V, inside the calibrated range of the published damper
ACCURACIES = ("strict", "fast")
SCALES = 500  # of the ensemble's motion, from 0.2 to 2
SAMPLE_VALUES = 20  # written of each array of the ensemble, beside its sha256
RIG_SEED = 20
CHANNELS = ("time", "displacement", "force", "velocity", "voltage", "current", "temperature")

CAMPAIGN_HEADER = """
name = "fingerprint"
seed = 3
rest_between = "0.5 s"
"""

STEPS = (
    """
[[step]]
kind = "sine"
amplitude = "6 mm"
frequency = "1 Hz"
voltage = "0 V"
cycles = 3
rest_before = "0.5 s"
""",
    """
[[step]]
kind = "sine"
amplitude = "5 mm"
frequency = "1.2 Hz"
voltage = "1.98 V"
cycles = 3
rest_before = "0.5 s"
""",
    """
[[step]]
kind = "random"
amplitude = "6 mm"
low = "0.5 Hz"
high = "2 Hz"
duration = "5 s"
taper = "1 s"
voltage = "0.8712 V"
seed = 7
rest_before = "0.5 s"
""",
    """
[[step]]
kind = "sweep"
amplitude = "4 mm"
start = "0.2 Hz"
stop = "2 Hz"
duration = "10 s"
voltage = "1.2 V"
""",
)

HEX_FLOAT = re.compile(r"-?0x[01]\.[0-9a-f]+p[+-]\d+|-?inf|nan")


def main() -> int:
    """Parse the command line, run or compare; the exit status."""
    parser = argparse.ArgumentParser(description="Fingerprint of dampyr's numerical results.")
    parser.add_argument("--out", type=Path, metavar="FILE", help="run, and write the results to this file")
    parser.add_argument("--root", type=Path, default=CHECKOUT, metavar="DIR", help="the checkout to run")
    parser.add_argument(
        "--data", type=Path, metavar="DIR", help="the folder of data (default: ../shared/data beside the checkout)"
    )
    parser.add_argument(
        "--only", nargs="+", choices=sorted(SECTIONS), metavar="SECTION", help=f"of {', '.join(sorted(SECTIONS))}"
    )
    parser.add_argument("--compare", nargs=2, type=Path, metavar=("A", "B"), help="compare two files of results")
    options = parser.parse_args()
    if (options.out is None) == (options.compare is None):
        parser.error("give either --out or --compare")
    if options.compare:
        return compare(*(json.loads(path.read_text(encoding="utf-8")) for path in options.compare))
    results = run(options.root.resolve(), options.data, options.only or list(SECTIONS))
    options.out.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    return 0


def run(root: Path, data: Path | None, sections: list[str]) -> dict[str, Any]:
    """The results of the sections with the sources of ``root``."""
    os.environ.update(dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1"))
    sys.path.insert(0, str(root / "src"))
    import dampyr

    if not Path(dampyr.__file__).resolve().is_relative_to(root):
        raise SystemExit(f"dampyr was imported from {dampyr.__file__}, which is not in {root}")
    folder = (data or root.parent / "shared" / "data").resolve()
    results: dict[str, Any] = {"environment": environment()}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the published damper outside its range of displacement, and the like
        for name in sections:
            start = time.perf_counter()
            results[name] = encoded(SECTIONS[name](dampyr, folder))
            print(f"{name}: {time.perf_counter() - start:.1f} s", file=sys.stderr, flush=True)
    return results


def environment() -> dict[str, str]:
    """What the results depend on besides the sources."""
    import numba
    import numpy as np
    import scipy

    return {
        "python": sys.version.split()[0],
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "numba": numba.__version__,
    }


def fits(dp: Any, data: Path) -> dict[str, Any]:
    """The joint fits of `MODELS`."""
    folder = data / CAMPAIGN_FOLDER
    if not folder.is_dir():
        raise SystemExit(f"there is no {folder}; name the folder of data with --data")
    records = dp.records.read_campaign(folder)
    results: dict[str, Any] = {"records": len(records)}
    for name, arguments in MODELS.items():
        steps: list[tuple[int, float]] = []
        fit = dp.identification.fit(
            records=records, progress=lambda step, cost, steps=steps: steps.append((step, cost)), **arguments
        )
        results[name] = {
            "parameters": dict(fit.parameters),
            "stderr": dict(fit.stderr),
            "cost": steps[-1][1],
            "cost_of_each_step": digest([cost for _, cost in steps]),
            "iterations": steps[-1][0],
            "converged": bool(fit.converged),
        }
    return results


def chapter_5(dp: Any, data: Path) -> dict[str, Any]:
    """The peaks of chapter 5."""
    building, motion = dp.structures.two_storey(), dp.ground_motions.el_centro()
    damper = dp.studies.raminelli_2020.damper()
    results = {}
    for accuracy in ACCURACIES:
        for voltage in (None, *VOLTAGES):
            dampers = None if voltage is None else {1: damper}
            response = dp.structures.respond(building, motion, dampers=dampers, voltage=voltage, accuracy=accuracy)
            results[f"{accuracy}, {'no damper' if voltage is None else f'{voltage:g} V'}"] = {
                "peak_displacement": numbers(response.peak_displacement),
                "peak_drift": numbers(response.peak_drift),
                "peak_acceleration": numbers(response.peak_acceleration),
                "force": digest(response.force),
            }
    return results


def ensemble(dp: Any, data: Path) -> dict[str, Any]:
    """10,000 cases, fast and strict."""
    import numpy as np

    first = dp.structures.two_storey()
    second = dp.structures.Building(M=1.2 * first.M, C=first.C, K=0.8 * first.K)
    damper = dp.studies.raminelli_2020.damper()
    results = {}
    for accuracy in ACCURACIES:
        peaks = dp.structures.ensemble(
            [first, second],
            dp.ground_motions.el_centro(),
            [damper, {1: damper, 2: damper}],
            list(VOLTAGES),
            np.linspace(0.2, 2.0, SCALES),
            accuracy=accuracy,
        )
        arrays = {}
        for name in sorted(str(each) for each in peaks.data_vars):
            values = peaks[name].to_numpy()
            places = np.linspace(0, values.size - 1, SAMPLE_VALUES).astype(int)
            arrays[name] = {
                "shape": list(values.shape),
                "sha256": digest(values),
                "samples": numbers(values.ravel()[places]),
            }
        results[accuracy] = arrays
    return results


def campaign(dp: Any, data: Path) -> dict[str, Any]:
    """Campaigns on the simulated rig in this process: of each step alone its record, of all together the journal."""
    results: dict[str, Any] = {"records": {}}
    with tempfile.TemporaryDirectory() as temporary:
        for k, step in enumerate(STEPS):
            folder = performed(dp, CAMPAIGN_HEADER + step, Path(temporary) / f"step-{k}")
            for record in dp.records.read_campaign(folder):
                channels = {name: getattr(record, name) for name in CHANNELS}
                digests = {name: digest(values) for name, values in channels.items() if values is not None}
                results["records"][record.name] = digests | {"samples": int(record.time.size)}
        folder = performed(dp, CAMPAIGN_HEADER + "".join(STEPS), Path(temporary) / "all")
        results["samples"] = [int(record.time.size) for record in dp.records.read_campaign(folder)]
        results |= journal(folder)
    return results


def performed(dp: Any, text: str, folder: Path) -> Path:
    """The folder of a campaign, given as text, that was performed on a simulated rig of its own."""
    folder.mkdir()
    plan = folder / "campaign.toml"
    plan.write_text(text, encoding="utf-8")
    with dp.rig.simulated(in_process=True, seed=RIG_SEED) as rig:
        return Path(dp.campaigns.perform(plan, rig, folder / "out"))


def journal(folder: Path) -> dict[str, list[Any]]:
    """The states of the tests and the kinds of the events that a campaign's journal holds."""
    with closing(sqlite3.connect(folder / "journal.sqlite")) as base:
        tests = base.execute("SELECT name, state, attempt FROM tests ORDER BY place").fetchall()
        events = base.execute("SELECT what FROM events ORDER BY id").fetchall()
    return {"tests": [list(row) for row in tests], "events": [what for (what,) in events]}


SECTIONS: dict[str, Callable[[Any, Path], dict[str, Any]]] = {
    "fits": fits,
    "chapter_5": chapter_5,
    "ensemble": ensemble,
    "campaign": campaign,
}


def numbers(values: Any) -> list[float]:
    """An array as a flat list of floats."""
    import numpy as np

    return [float(value) for value in np.asarray(values, dtype=float).ravel()]


def digest(values: Any) -> str:
    """The sha256 of an array's type, shape and bytes; of a mapping, of its values' digests by name."""
    import numpy as np

    if hasattr(values, "items"):
        return hashlib.sha256("".join(f"{key}={digest(each)};" for key, each in values.items()).encode()).hexdigest()
    array = np.ascontiguousarray(values)
    if array.dtype == object:
        raise TypeError(f"{type(values).__name__} is not an array of numbers")
    head = f"{array.dtype.str}{array.shape}".encode()
    return hashlib.sha256(head + array.tobytes()).hexdigest()


def encoded(value: Any) -> Any:
    """A result with its floats in hexadecimal."""
    if isinstance(value, dict):
        return {str(key): encoded(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [encoded(each) for each in value]
    return float(value).hex() if isinstance(value, float) else value


def leaves(value: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Every leaf of nested results with its path."""
    if isinstance(value, dict | list):
        pairs = value.items() if isinstance(value, dict) else enumerate(value)
        for key, each in pairs:
            yield from leaves(each, (*path, str(key)))
    else:
        yield path, value


def compare(a: dict[str, Any], b: dict[str, Any]) -> int:
    """Print what differs between two results; 1 where anything does."""
    first, second = a.pop("environment", {}), b.pop("environment", {})
    if first != second:
        print(f"note: the environments differ: {first}, {second}")
    left, right = dict(leaves(a)), dict(leaves(b))
    different = [
        path for path in {**left, **right} if path not in left or path not in right or left[path] != right[path]
    ]
    largest: dict[str, float] = {}
    for path in different:
        text, size = difference(left, right, path)
        print(f"{' / '.join(path)}: {text}")
        largest[path[0]] = max(largest.get(path[0], 0.0), size)
    for section in sorted({path[0] for path in {**left, **right}}):
        total = sum(path[0] == section for path in {**left, **right})
        count = sum(path[0] == section for path in different)
        largest_text = f", largest relative difference {largest[section]:.2g} among the numbers" if count else ""
        print(f"{section}: {count} of {total} values differ{largest_text}")
    return 1 if different else 0


def difference(
    left: dict[tuple[str, ...], Any], right: dict[tuple[str, ...], Any], path: tuple[str, ...]
) -> tuple[str, float]:
    """How two leaves differ, in words, and the relative difference where both are floats (else 0)."""
    if path not in left or path not in right:
        return f"only in {'B' if path in right else 'A'}", 0.0
    a, b = left[path], right[path]
    if not all(isinstance(each, str) and HEX_FLOAT.fullmatch(each) for each in (a, b)):
        return f"{a} -> {b}", 0.0
    x, y = float.fromhex(a), float.fromhex(b)
    size = abs(x - y) / max(abs(x), abs(y)) if math.isfinite(x) and math.isfinite(y) else math.inf
    return f"{x!r} -> {y!r}, relative {size:.2g}", size


if __name__ == "__main__":
    sys.exit(main())
