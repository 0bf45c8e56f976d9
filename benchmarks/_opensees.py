"""The building of chapter 5 in OpenSees: Newmark's average acceleration, the damper as OpenSees' own BoucWen material.

Dahl is Bouc-Wen with n = 1 and the whole coefficient on the term with |v|, which OpenSees calls beta (its gamma is 0). With
A = beta = rho the material's z is Dahl's w, of size one as its own Newton's tolerance expects, and its force is ko z, ko = kw.
The floors are joined by zero-length elements whose springs and dashpots give the K and C of the building to the last digit.
"""

from __future__ import annotations

import importlib
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks._suite import Case
from dampyr.structures import two_storey

Array = NDArray[np.float64]
PLACES = ("openseespylinux.opensees", "openseespy.opensees")
INSTALL = "missing or does not load; pip install openseespy, on Debian also apt install libblas3 liblapack3"
GROUND, FIRST, ROOF = 0, 1, 2


def opensees() -> Any:
    """The module of OpenSees; ImportError says why it is not there."""
    for name in PLACES:
        try:
            return importlib.import_module(name)
        except (ImportError, RuntimeError):
            continue
    raise ImportError(INSTALL)


def missing() -> str:
    """Why OpenSees cannot run, or nothing."""
    try:
        opensees()
    except ImportError as error:
        return str(error)
    return ""


def peaks(cases: list[Case], m: int) -> Array:
    """(cases, 2): the peaks of the first floor and of the second storey's drift, with m steps to a sample."""
    return np.array([_one(opensees(), case, m) for case in cases])


def _one(ops: Any, case: Case, m: int) -> tuple[float, float]:
    ops.wipe()
    _building(ops, case.damper)
    ops.timeSeries("Path", 1, "-dt", case.dt, "-values", *case.acceleration.tolist())
    ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
    with tempfile.TemporaryDirectory() as folder:
        floor, drift = Path(folder) / "floor.txt", Path(folder) / "drift.txt"
        ops.recorder("EnvelopeNode", "-file", str(floor), "-node", FIRST, "-dof", 1, "disp")
        ops.recorder("EnvelopeElement", "-file", str(drift), "-ele", 2, "deformation")
        _scheme(ops)
        failed = ops.analyze((len(case.acceleration) - 1) * m, case.dt / m)
        ops.wipe()  # only now are the files complete
        return (np.nan, np.nan) if failed else (_largest(floor), _largest(drift))


def _building(ops: Any, damper: tuple[float, float, float]) -> None:
    building, (kx, kw, rho) = two_storey(), damper
    K, C = building.K, building.C
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    for node in (GROUND, FIRST, ROOF):
        ops.node(node, 0.0)
    ops.fix(GROUND, 1)
    for node in (FIRST, ROOF):
        ops.mass(node, float(building.M[node - 1, node - 1]))
    ops.uniaxialMaterial("Elastic", 1, *_pair(K[0].sum(), C[0].sum() + kx))
    ops.uniaxialMaterial("Elastic", 2, *_pair(-K[0, 1], -C[0, 1]))
    ops.uniaxialMaterial("Elastic", 3, *_pair(K[1].sum(), C[1].sum()))
    alpha, n, gamma, beta, amplitude = 0.0, 1.0, 0.0, rho, rho
    ops.uniaxialMaterial("BoucWen", 4, alpha, kw, n, gamma, beta, amplitude, 0.0, 0.0, 0.0, 1e-10, 50)
    for tag, ends in enumerate(((GROUND, FIRST), (FIRST, ROOF), (GROUND, ROOF), (GROUND, FIRST)), 1):
        ops.element("zeroLength", tag, *ends, "-mat", tag, "-dir", 1)


def _pair(stiffness: float, dashpot: float) -> tuple[float, float]:
    return float(stiffness), float(dashpot)


def _scheme(ops: Any) -> None:
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("FullGeneral")
    ops.test("NormDispIncr", 1e-9, 50, 0)
    ops.algorithm("Newton")
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")


def _largest(path: Path) -> float:
    """The last line of an envelope file: least, greatest and largest size stand below each other."""
    return float(np.loadtxt(path)[-1])
