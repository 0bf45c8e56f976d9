"""Fingerprint of dampyr's numerical results: run on two checkouts, compare bit for bit.

::

    python tools/fingerprint.py --out before.json --root ../other-checkout
    python tools/fingerprint.py --out after.json
    python tools/fingerprint.py --compare before.json after.json
    python tools/fingerprint.py --texts after.txt

``--out`` imports dampyr from the sources of the checkout ``--root`` (default: the one that holds this script), runs its
sections and writes their results as JSON. Floats are written in hexadecimal (``float.hex``), so nothing is rounded:

``fits``
    The joint fits of four models (`MODELS`) to the 38 records of the published campaign: parameters and standard errors by
    label, the correlation, the levels of the records, what the records hardly separate, the scores of the fitted records, the
    final cost, the number of iterations, whether the search converged.
``laws``
    Fits of Dahl's model with a law of each kind: parameters, and the model at inputs between the measured ones.
``dissertation_methods``
    The limit cycle and the plastic region of a record, the dissertation's own ways to a model.
``scores``
    What a card scores on records that it was fitted to and on the one kept apart: every number of a score, its prediction
    band, and a validation by parts.
``leaderboard``
    A search over few models on synthetic records: what was screened, the entries and their order.
``evidence``
    The profile of a parameter, samples of the posterior, draws of a damper, and the spread of three specimens.
``acceptance``
    Records judged against a card and against other records: every point with its limits and the chances of a wrong verdict.
``plan``
    What a campaign needs on a rig, test by test, and which tests are proposed next.
``chapter_5``
    The building of chapter 5 under El Centro, without and with the published damper at several voltages, at the accuracies
    "strict" and "fast": the peaks of every floor and storey, and the sha256 of the force's history.
``ensemble``
    10,000 cases (2 buildings x 2 placements x 5 voltages x 500 scales) at the accuracies "fast" and "strict": for each array
    of peaks its shape, its sha256 and 20 values at even distances; and curves of fragility.
``hybrid``
    A hybrid test on an actuator that is late, a virtual one with its criteria, and ten random plants.
``exports``
    The sha256 of a card, of each text file that it exports, and of a record as text; dampyr's version, the digest of its
    sources and the date are taken out before.
``campaign``
    Four tests on a simulated rig in this process, with a fixed seed: the sha256 of each channel of each record, where each
    test is a campaign of its own on a fresh rig; and of one campaign of all four the number of samples, the states of the
    tests in the journal and the kinds of its events. (Between two tests the rig reads on for as long as the file of the first
    takes to be finished, so on a busy machine the bits of the second depend on the disk.)

``--texts FILE`` writes, beside or in place of the numbers, what every public object says of itself: the examples of the
checkout's own tests/invariants/test_representations.py, each with its text and its table. Their change is read as a diff.

``--compare`` prints the leaves that differ, each with its difference relative to the larger of the two, then the largest
one by section; the exit status is 1 where anything differs. Versions of Python, numpy, scipy and numba are recorded; where
they differ a line says so, and it does not count as a difference.

Only calls of the public face are used (the journal is read as the SQLite file that it is). Those that are renamed or folded
together after 0.3.0 go through one adapter, `Calls`, so the same script runs on old and new sources. BLAS runs on one thread;
ensembles run on one thread per core, and their numbers do not depend on it. Results are reproducible on one machine with one
set of packages; another processor may round differently, and is named beside the versions.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import importlib
import inspect
import json
import math
import os
import re
import sqlite3
import subprocess
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

LAWS = ("constant", "interpolation", "polynomial:1", "polynomial:3", {"*": "polynomial:2", "dahl.rho": "constant"})
BETWEEN = (0.4, 1.5, 2.7)  # V, inputs at which nothing was measured
SINES = ((0.005, 1.0), (0.010, 0.5), (0.008, 0.8), (0.004, 1.6))  # m, Hz: the motions of synthetic records
NOISE = 8.0  # N
SCORE = ("l1", "nrmse", "r2", "pointwise", "peak_force", "energy", "offset", "level", "relevelled_l1")
BAND = ("level", "holds", "width")
POINT = (
    "cycle",
    "quantity",
    "speed",
    "stroke_m",
    "measured",
    "expected",
    "low",
    "high",
    "inside",
    "level",
    "error",
    "allowance",
)
PLANNED = ("duration", "peak_speed", "peak_position", "peak_force", "peak_voltage", "energy")
LEVELS = ("record_sd", "record_freedom", "session_sd", "session_freedom", "session_reml", "repeated", "named")
SMALL = 200  # numbers of an array that are written, and not their digest
SPECIMENS = ("mean", "mean_interval", "spread", "spread_interval", "new_specimen", "estimates", "errors", "shrunken")
TEXT_RECORDS = ("csv",)  # of the formats that a record is written in, those whose bytes are its numbers alone
VERSION = re.compile(
    r"\d+\.\d+\.\d+(?:\.dev\d+)?\+[0-9a-f]{12}|\b[0-9a-f]{64}\b|\{[0-9a-f-]{36}\}"
)  # a digest of sources, of a file, a GUID

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
    parser.add_argument("--texts", type=Path, metavar="FILE", help="write what every public object says of itself")
    parser.add_argument("--compare", nargs=2, type=Path, metavar=("A", "B"), help="compare two files of results")
    options = parser.parse_args()
    if options.compare:
        return compare(*(json.loads(path.read_text(encoding="utf-8")) for path in options.compare))
    if options.out is None and options.texts is None:
        parser.error("give --out, --texts or --compare")
    if options.out is not None:
        results = run(options.root.resolve(), options.data, options.only or list(SECTIONS))
        options.out.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    if options.texts is not None:
        options.texts.write_text(texts(options.root.resolve()), encoding="utf-8")
    return 0


def run(root: Path, data: Path | None, sections: list[str]) -> dict[str, Any]:
    """The results of the sections with the sources of ``root``."""
    dampyr = imported(root)
    folder = (data or root.parent / "shared" / "data").resolve()
    results: dict[str, Any] = {"code": code(root), "environment": environment()}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the published damper outside its range of displacement, and the like
        for name in sections:
            start = time.perf_counter()
            results[name] = encoded(SECTIONS[name](dampyr, folder))
            print(f"{name}: {time.perf_counter() - start:.1f} s", file=sys.stderr, flush=True)
    return results


def imported(root: Path) -> Any:
    """dampyr from the sources of the checkout ``root``, with one thread for BLAS."""
    os.environ.update(dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1"))
    sys.path[:0] = [str(root / "src"), str(root)]
    import dampyr

    if not Path(dampyr.__file__).resolve().is_relative_to(root):
        raise SystemExit(f"dampyr was imported from {dampyr.__file__}, which is not in {root}")
    return dampyr


def code(root: Path) -> str:
    """The checkout's commit, marked where its files differ from it, and the version with the digest of the sources."""
    words = ("git", "-C", str(root), "describe", "--always", "--dirty", "--abbrev=12")
    described = subprocess.run(words, capture_output=True, text=True, check=False).stdout.strip()
    return f"{described}, dampyr {importlib.import_module('dampyr.source_digest').full_version()}"


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
        "processor": processor(),
    }


def processor() -> str:
    """The model of the processor: another one may round differently."""
    import platform

    lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines() if Path("/proc/cpuinfo").exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


class Calls:
    """The public calls whose names or arguments differ between 0.3.0 and what follows it, by one way of asking for each."""

    def __init__(self, dp: Any) -> None:
        self.dp = dp
        self.identification = dp.identification

    def campaign(self, data: Path) -> list[Any]:
        """The 38 records of the published campaign."""
        folder = data / CAMPAIGN_FOLDER
        if not folder.is_dir():
            raise SystemExit(f"there is no {folder}; name the folder of data with --data")
        return list(self.dp.records.read_campaign(folder))

    def fit(self, records: list[Any], model: Any, **options: Any) -> Any:
        """One model fitted; ``records`` and ``model`` changed places.

        Since 0.4.0 `fit` holds what a pair of parts leaves to one of them, as the command did before; a law that names the
        parameter leaves it free.
        """
        if model == "dahl + hyperbolic_tangent" and not hasattr(self.identification, "identify"):
            options = {"laws": {"hyperbolic_tangent.s": "interpolation"}} | options
        return self.identification.fit(records=records, model=model, **options)

    def steps_of_search(self, records: list[Any], model: Any, **options: Any) -> list[tuple[int, float]]:
        """Number and cost of each step of a fit's search: what ``progress`` of `fit` was called with, later of its search."""
        steps: list[tuple[int, float]] = []

        def watch(step: int, cost: float) -> None:
            steps.append((step, cost))

        if hasattr(self.identification, "identify"):
            self.identification.fit(records=records, model=model, progress=watch, **options)
        else:
            least_squares = importlib.import_module("dampyr.identification.fits.least_squares")
            least_squares.fit_model(model, records, self.identification.FitOptions(**options), watch)
        return steps

    def inseparable(self, fit: Any) -> Any:
        """What the records of a fit cannot separate: ``findings``, later ``inseparable``."""
        result = self.identification.identifiability(fit)
        return result.inseparable if hasattr(result, "inseparable") else result.findings

    def leaderboard(self, records: list[Any], **options: Any) -> Any:
        """The search for a model: later `fit` without one."""
        if hasattr(self.identification, "leaderboard"):
            return self.identification.leaderboard(records, **options)
        return self.identification.fit(records, **options).leaderboard

    def predicted(self, records: list[Any], model: str, folds: int) -> Any:
        """Records predicted by fits without them: `cross_validate`, later `fit` with ``predict``."""
        if hasattr(self.identification, "cross_validate"):
            return self.identification.cross_validate(model, records, folds=folds)
        return self.identification.fit(records, model, predict="record", folds=folds).validations[0]

    def validate(self, damper: Any, records: list[Any], **options: Any) -> Any:
        """Scores of many records, by input."""
        return self._with_options(self.identification.validate, "ValidateOptions", (damper, records), options)

    def accept(self, records: list[Any], reference: Any, **options: Any) -> Any:
        """Records judged: `accept_records`, later `accept`."""
        accept = getattr(self.identification, "accept_records", self.identification.accept)
        return self._with_options(accept, "AcceptOptions", (records, reference), options)

    def _with_options(self, call: Callable[..., Any], name: str, data: tuple[Any, ...], options: dict[str, Any]) -> Any:
        """A call that takes its options in an object of the class ``name``, or by their names."""
        if set(options) <= set(inspect.signature(call).parameters):
            return call(*data, **options)
        return call(*data, getattr(self.identification, name)(**options))

    def ensemble(self, *data: Any, voltages: list[float], scales: Any, **options: Any) -> Any:
        """Dataset of peaks; the inputs became ``voltage`` as in `respond`, and the dataset a part of the result."""
        ensemble = self.dp.structures.ensemble
        name = "voltage" if "voltage" in inspect.signature(ensemble).parameters else "voltages"
        peaks = ensemble(*data, scales=scales, **{name: voltages}, **options)
        return peaks if name == "voltages" else peaks.dataset

    def plan(self, path: Path) -> Any:
        """What a campaign's file needs on the default rig: `planned`, later `plan`."""
        return getattr(self.dp.campaigns, "planned", self.dp.campaigns.plan)(path)

    def propose(self, evidence: Any, **options: Any) -> Any:
        """The tests that are proposed next: of `campaigns`, later of `planning`."""
        package = self.dp.campaigns if hasattr(self.dp.campaigns, "propose") else self._package("planning")
        return package.propose(evidence, **options)

    @property
    def hybrid(self) -> Any:
        """The package of hybrid tests: in `campaigns`, later beside it."""
        for name in ("hybrid", "campaigns.hybrid"):
            try:
                return self._package(name)
            except ModuleNotFoundError as error:
                if error.name != f"dampyr.{name}":
                    raise
        raise SystemExit("there is no package of hybrid tests")

    def delayed_result(self, *args: Any, **options: Any) -> Any:
        """A hybrid test on a late actuator: of the package, later of its module alone."""
        holder = self.hybrid if hasattr(self.hybrid, "delayed_result") else self._package("hybrid.delayed_hybrid")
        return holder.delayed_result(*args, **options)

    def _package(self, name: str) -> Any:
        return importlib.import_module(f"dampyr.{name}")


def fits(dp: Any, data: Path) -> dict[str, Any]:
    """The joint fits of `MODELS`."""
    calls = Calls(dp)
    records = calls.campaign(data)
    results: dict[str, Any] = {"records": len(records)}
    for name, arguments in MODELS.items():
        fit = calls.fit(records, **arguments)
        steps = calls.steps_of_search(records, **arguments)
        pairs = calls.inseparable(fit)
        results[name] = {
            "parameters": dict(fit.parameters),
            "stderr": dict(fit.stderr),
            "naive_stderr": dict(fit.naive_stderr),
            "correlation": numbers(fit.correlation),
            "freedom": plain(fit.freedom),
            "levels": plain(fit.levels, ("level", "session", *LEVELS, "by_session")),
            "separated": [[finding.kind, list(finding.labels), dict(finding.numbers)] for finding in pairs],
            "scores": {name: float(score.l1) for name, score in fit.scores.items()},
            "cost": steps[-1][1],
            "cost_of_each_step": digest([cost for _, cost in steps]),
            "iterations": steps[-1][0],
            "converged": bool(fit.converged),
        }
    return results


def laws(dp: Any, data: Path) -> dict[str, Any]:
    """Dahl's model with a law of each kind."""
    calls = Calls(dp)
    records = calls.campaign(data)
    results = {}
    for law in LAWS:
        fit = calls.fit(records, "dahl", laws=law)
        between = {
            f"{name} @ {voltage:g} V": law_of(voltage)
            for name, law_of in fit.damper.all_laws.items()
            for voltage in BETWEEN
        }
        results[json.dumps(law)] = {"parameters": dict(fit.parameters), "stderr": dict(fit.stderr), "between": between}
    return results


def dissertation_methods(dp: Any, data: Path) -> dict[str, Any]:
    """The dissertation's own ways to a model: the loading branch of the published damper, and a record of each voltage."""
    import numpy as np

    damper, voltage = dp.studies.raminelli_2020.damper(), 0.8712
    t = np.arange(0.0, 3.0, 1e-3)
    x, v = -0.01 * np.cos(2 * np.pi * t), 0.02 * np.pi * np.sin(2 * np.pi * t)
    force = damper.force(t, x, voltage=voltage, velocity=v)
    rising = slice(2000, 2501)  # of the third cycle
    kx = damper.all_laws["dahl.kx"](voltage)  # (2.5) is 0/0 where the velocity at both ends is zero
    cycle = dp.identification.limit_cycle(x[rising], force[rising], v[rising], kx=kx)
    names = ("kx", "kw", "rho", "a", "offset", "rho_spread", "share", "turning_points")
    regions = {
        f"{record.voltage:g} V": plain(dp.identification.plastic_region(record), names)
        for record in {record.voltage: record for record in Calls(dp).campaign(data)}.values()
    }
    return {
        "limit_cycle": plain(cycle, ("kx", "a", "rho", "kw", "x_star", "x_star1", "rho_range")),
        "plastic_region": regions,
    }


def scores(dp: Any, data: Path) -> dict[str, Any]:
    """Scores of a card, with bands, and a validation by parts."""
    calls = Calls(dp)
    records = calls.campaign(data)
    fit = calls.fit([record for record in records if record.role == "fit"], "dahl + hyperbolic_tangent")
    validation = [record for record in records if record.role != "fit"]
    results: dict[str, Any] = {}
    for record in [*records[:4], *validation]:
        score = dp.identification.score(fit.damper, record, band=0.9)
        band = score.band
        results[record.name] = (
            plain(score, SCORE)
            | {"window": [score.window.start, score.window.end]}
            | {
                "band": None
                if band is None
                else plain(band, BAND)
                | {name: plain(getattr(band, name), ("low", "high", "measured")) for name in ("peak", "energy")}
            }
        )
    validated = calls.validate(fit.damper, records, band=None)
    results["validate"] = {name: plain(score, SCORE) for name, score in validated.scores.items()}
    parts = calls.predicted(records, "dahl", folds=4)
    results["cross_validate"] = {name: plain(score, SCORE) for name, score in parts.scores.items()}
    return results


def synthetic_records(
    dp: Any, voltages: tuple[float, ...] = (0.0, 1.0, 2.0), first: int = 0, factor: float = 1.0
) -> list[Any]:
    """Records of the published damper with noise, four motions at each voltage; its force ``factor`` times as large."""
    import numpy as np

    damper = dp.studies.raminelli_2020.damper()
    records = []
    for k, (voltage, (amplitude, frequency)) in enumerate((u, motion) for u in voltages for motion in SINES):
        t = np.arange(0.0, 6.0, 0.005)
        run = np.maximum(t - 0.5, 0.0)
        x = amplitude * np.minimum(run * frequency, 1.0) * np.sin(2 * np.pi * frequency * run)
        v = np.gradient(x, t)
        force = factor * damper.force(t, x, voltage=voltage, velocity=v, allow_extrapolation=True)
        noise = np.random.default_rng(first + k).normal(0.0, NOISE, t.size)
        records.append(
            dp.records.Record(
                time=t, displacement=x, velocity=v, force=force + 120.0 + noise, voltage=voltage, name=f"{first + k}"
            )
        )
    return records


def leaderboard(dp: Any, data: Path) -> dict[str, Any]:
    """A search over three models and two add-ons on synthetic records."""
    board = Calls(dp).leaderboard(
        synthetic_records(dp),
        models=("dahl", "hyperbolic_tangent", "bingham"),
        add_ons=("spring", "delay"),
        finalists=3,
        budget=60.0,
    )
    numbers_of = (
        "model",
        "error",
        "standard_error",
        "l1",
        "nrmse",
        "pointwise",
        "energy",
        "unseen_input",
        "parameters",
        "work",
    )
    return {
        "screened": [
            [tried.base, [plain(trial, ("model", "error", "work")) for trial in tried.trials]]
            for tried in board.screened
        ],
        "entries": [plain(entry, numbers_of) for entry in board.entries],
        "winner": board.winner.model,
        "work": float(board.work),
        "optimism": float(board.optimism),
    }


def evidence(dp: Any, data: Path) -> dict[str, Any]:
    """A profile, a posterior, draws of a damper and three specimens."""
    import numpy as np

    calls = Calls(dp)
    fit = calls.fit(synthetic_records(dp), "dahl")
    profile = dp.identification.profile(fit, "dahl.rho @ 1 V", points=11)
    posterior = dp.identification.sample_posterior(fit, steps=1500)
    groups = {f"damper {n}": synthetic_records(dp, (1.0,), 100 * (n + 1), 1.0 + 0.05 * n) for n in range(3)}
    specimens = dp.identification.fit_specimens(model="dahl", records=groups)
    draws = [{name: float(law(1.0)) for name, law in damper.all_laws.items()} for damper in fit.damper.draws(5, seed=3)]
    return {
        "profile": plain(
            profile, ("value", "standard_error", "freedom", "threshold", "values", "rise", "interval", "closed")
        ),
        "posterior": {name: digest(values) for name, values in posterior.samples.items()}
        | {
            "r_hat": plain(posterior.r_hat),
            "mean": {name: float(np.mean(values)) for name, values in posterior.samples.items()},
        },
        "draws": draws,
        "specimens": {name: plain(spread, SPECIMENS) for name, spread in specimens.spreads.items()},
    }


def acceptance(dp: Any, data: Path) -> dict[str, Any]:
    """Records judged against a card, and against other records of the same motions."""
    calls = Calls(dp)
    records = calls.campaign(data)
    fit = calls.fit(records, "dahl + hyperbolic_tangent")
    results: dict[str, Any] = {}
    judged = {
        "card": calls.accept(records[:2], fit.damper),
        "records": calls.accept(synthetic_records(dp, (1.0,), 500, 1.1), synthetic_records(dp, (1.0,), 600)),
    }
    for name, accepted in judged.items():
        results[name] = {
            result.record: plain(
                result, ("offset", "reason", "run", "cut", "stroke_m", "wrong_rejection", "wrong_acceptance", "passed")
            )
            | {"points": [plain(point, POINT) for point in result.points]}
            for result in accepted.results
        }
    return results


def plan(dp: Any, data: Path) -> dict[str, Any]:
    """What the campaign of `campaign` needs, and a proposal."""
    calls = Calls(dp)
    with tempfile.TemporaryDirectory() as temporary:
        path = Path(temporary) / "campaign.toml"
        path.write_text(CAMPAIGN_HEADER + "".join(STEPS), encoding="utf-8")
        planned = calls.plan(path)
        tests = {test.name: plain(test, PLANNED) for test in planned.tests}
    fit = calls.fit(synthetic_records(dp), "dahl")
    proposal = calls.propose(fit, tests=3, seconds=6.0, voltages=(0.0, 1.98))
    return {
        "tests": tests,
        "duration": float(planned.duration),
        "proposal": {
            "document": plain(proposal.document),
            "before": plain(proposal.before),
            "after": plain(proposal.after),
            "duration": float(proposal.duration),
        },
    }


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
    results: dict[str, Any] = {}
    for accuracy in ACCURACIES:
        peaks = Calls(dp).ensemble(
            [first, second],
            dp.ground_motions.el_centro(),
            [damper, {1: damper, 2: damper}],
            voltages=list(VOLTAGES),
            scales=np.linspace(0.2, 2.0, SCALES),
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
        curves = dp.structures.fragility(peaks, limit=0.015, draws=50, by=("input",)).curves
        results[f"{accuracy}, fragility"] = [plain(curve, ("name", "theta", "beta")) for curve in curves]
    return results


def hybrid(dp: Any, data: Path) -> dict[str, Any]:
    """A late actuator, a virtual test and random plants."""
    calls = Calls(dp)
    tests = calls.hybrid
    damper, motion = dp.studies.raminelli_2020.damper(), dp.ground_motions.el_centro()
    late = calls.delayed_result(dp.structures.two_storey(), motion, damper, 0.010, value=0.8712)
    setup = tests.HybridSetup(dp.studies.vrths_2020.structure(1))
    compensator = tests.KalmanCompensator.designed(setup)
    run = tests.perform_virtual(setup, compensator, motion)
    batch = tests.run_many(setup, compensator, motion, 10, workers=1)
    return {
        "late": plain(late, ("lag", "gain", "energy_error", "tracking_error", "static_force"))
        | {name: digest(getattr(late, name)) for name in ("displacement", "target", "achieved", "force")},
        "virtual": {
            "criteria": plain(run.criteria()),
            "stability": plain(
                tests.loop_stability(setup, compensator), ("radius", "frequency", "growth", "start_radius")
            ),
        }
        | {name: digest(getattr(run, name)) for name in ("floors", "displacement", "measured", "command", "force")},
        "plants": plain(batch, ("true", "measured", "radius", "at_limit", "diverged")),
    }


def exports(dp: Any, data: Path) -> dict[str, Any]:
    """The text files of each kind of export, and a record as text."""
    calls = Calls(dp)
    fit = calls.fit(synthetic_records(dp), "dahl + spring")
    results: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        fit.damper.save(folder / "card.toml")
        results["card"] = text_digest(folder / "card.toml")
        for kind in dp.export.available_kinds():
            if kind == "fmu":  # needs a compiler, and holds the C source
                continue
            dp.export.export(fit.damper, kind, folder / kind)
            results[kind] = {
                str(path.relative_to(folder / kind)): text_digest(path)
                for path in sorted((folder / kind).rglob("*"))
                if path.is_file()
            }
        for kind in TEXT_RECORDS:
            results[kind] = text_digest(Path(dp.records.write(synthetic_records(dp)[0], folder / f"record.{kind}")))
    return results


def text_digest(path: Path) -> str:
    """The sha256 of a text without versions, digests of sources, identifiers and dates."""
    text = VERSION.sub("VERSION", path.read_text(encoding="utf-8"))
    return hashlib.sha256(re.sub(r"\d{4}-\d{2}-\d{2}([T ][\d:.+-]+)?", "DATE", text).encode()).hexdigest()


def texts(root: Path) -> str:
    """The text and the table of each example of the checkout's own tests, by class."""
    imported(root)
    cases: Any = importlib.import_module("tests.invariants.test_representations")

    class Folders:
        """Gives the fixture its folders."""

        def mktemp(self, name: str) -> Path:
            folder = Path(tempfile.mkdtemp()) / name
            folder.mkdir()
            return folder

    lines: list[str] = []
    fixture = inspect.unwrap(cases.made)(Folders())
    things = next(fixture)
    for name, example in sorted(cases.EXAMPLES.items()):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            thing = example(things)
        lines += [f"==== {name}", re.sub(r"/tmp/\S+", "FOLDER", VERSION.sub("VERSION", repr(thing)))]
        with contextlib.suppress(AttributeError, ValueError):  # what is not a table
            frame = thing.to_dataframe().head(12)
            lines += ["---- to_dataframe", frame.to_csv(index=False, float_format="%.6g").rstrip()]
    next(fixture, None)
    return "\n".join(lines) + "\n"


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
    with dp.rig.simulated(seed=RIG_SEED) as rig:
        performed = dp.campaigns.perform(plan, rig, folder / "out")
        return Path(getattr(performed, "folder", performed))


def journal(folder: Path) -> dict[str, list[Any]]:
    """The states of the tests and the kinds of the events that a campaign's journal holds."""
    with closing(sqlite3.connect(folder / "journal.sqlite")) as base:
        tests = base.execute("SELECT name, state, attempt FROM tests ORDER BY place").fetchall()
        events = base.execute("SELECT what FROM events ORDER BY id").fetchall()
    return {"tests": [list(row) for row in tests], "events": [what for (what,) in events]}


SECTIONS: dict[str, Callable[[Any, Path], dict[str, Any]]] = {
    "fits": fits,
    "laws": laws,
    "dissertation_methods": dissertation_methods,
    "scores": scores,
    "leaderboard": leaderboard,
    "evidence": evidence,
    "acceptance": acceptance,
    "plan": plan,
    "chapter_5": chapter_5,
    "ensemble": ensemble,
    "hybrid": hybrid,
    "exports": exports,
    "campaign": campaign,
}


def plain(value: Any, names: tuple[str, ...] = ()) -> Any:
    """A result as numbers and texts: of an object its attributes ``names``, of mappings, sequences and arrays all."""
    import dataclasses

    import numpy as np

    if names:
        return {name: plain(getattr(value, name)) for name in names}
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return plain(value.tolist()) if value.size <= SMALL else {"shape": list(value.shape), "sha256": digest(value)}
    if hasattr(value, "items"):
        return {str(key): plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    if dataclasses.is_dataclass(value):
        return {field.name: plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if value is None or isinstance(value, bool | int | float | str):
        return value
    raise TypeError(f"{type(value).__name__} has no numbers that are known here; name its attributes")


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
    print(f"A: {a.pop('code', 'not stated')}\nB: {b.pop('code', 'not stated')}")
    first, second = a.pop("environment", {}), b.pop("environment", {})
    if first != second:
        print(f"note: the environments differ: {first}, {second}")
    for section in sorted({*a} ^ {*b}):
        print(f"{section}: only in {'A' if section in a else 'B'}, not compared")
    left, right = ({path: value for path, value in leaves(each) if path[0] in {*a} & {*b}} for each in (a, b))
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
