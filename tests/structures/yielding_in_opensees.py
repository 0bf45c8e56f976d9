"""A yielding shear building in OpenSees, run as a script: JSON in, drifts as JSON out. A process of its own, as a fault in
OpenSees would end the tests.

With heights each storey has a vertical truss of the weight above it whose ends OpenSees turns exactly (corotational): P-delta.
"""

import json
import sys
from itertools import pairwise

from opensees_module import opensees

STIFF = 1e13  # N, of a truss that only turns


def main(r):
    ops, n = opensees(), len(r["masses"])
    ops.wipe()
    ops.model("basic", "-ndm", 2, "-ndf", 2)
    heights = r["heights"] or [1.0] * n
    alpha = r["hardening"] if isinstance(r["hardening"], list) else [r["hardening"]] * n
    for floor in range(n + 1):
        ops.node(floor, 0.0, sum(heights[:floor]))
    ops.fix(0, 1, 1)
    for k in range(n):
        ops.fix(k + 1, 0, 0 if r["heights"] else 1)
        ops.mass(k + 1, r["masses"][k], 1e-6)
        fy = r["stiffnesses"][k] * r["yield_drifts"][k]
        if r["exponent"] is None:
            ops.uniaxialMaterial("Steel01", k + 1, fy, r["stiffnesses"][k], max(alpha[k], 1e-12))
        else:
            half = 0.5 / r["yield_drifts"][k] ** r["exponent"]
            energy = (1.0 - alpha[k]) * r["stiffnesses"][k] * r["yield_drifts"][k] ** 2
            ops.uniaxialMaterial(
                "BoucWen",
                k + 1,
                alpha[k],
                r["stiffnesses"][k],
                r["exponent"],
                half,
                half,
                1.0,
                0.0,
                r.get("strength_loss", 0.0) / energy,
                r.get("stiffness_loss", 0.0) / energy,
                1e-12,
                200,
            )
        ops.uniaxialMaterial("Elastic", 100 + k, 0.0, r["dashpots"][k])
        ops.element("zeroLength", k + 1, *_joined(ops, k, heights), "-mat", k + 1, 100 + k, "-dir", 1, 1)
        if r["heights"]:
            ops.uniaxialMaterial("Elastic", 200 + k, STIFF)
            ops.element("corotTruss", 50 + k, k, k + 1, 1.0, 200 + k)
    _solver(ops, r)
    if r["heights"]:
        ops.timeSeries("Linear", 2)
        ops.pattern("Plain", 2, 2)
        for k in range(n):
            ops.load(k + 1, 0.0, -9.80665 * r["masses"][k])
        ops.integrator("LoadControl", 0.1)
        ops.analysis("Static")
        assert ops.analyze(10) == 0
        ops.loadConst("-time", 0.0)
        ops.wipeAnalysis()
        _solver(ops, r)
    ops.timeSeries("Path", 1, "-dt", r["dt"], "-values", *r["acceleration"])
    ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")
    peaks, steps = [0.0] * n, round((len(r["acceleration"]) - 1) * r["dt"] / r["step"])
    for _ in range(steps):
        assert ops.analyze(1, r["step"]) == 0
        x = [0.0, *(ops.nodeDisp(k + 1, 1) for k in range(n))]
        drifts = [b - a for a, b in pairwise(x)]
        peaks = [max(peak, abs(drift)) for peak, drift in zip(peaks, drifts, strict=True)]
    print(json.dumps({"peaks": peaks, "last": drifts}))


def _joined(ops, k, heights):
    """A node at the place of the upper floor that moves in x with the lower one, and the upper floor: a spring is a storey."""
    if k == 0:
        ops.node(500, 0.0, heights[0])
        ops.fix(500, 1, 1)
    else:
        ops.node(500 + k, 0.0, sum(heights[: k + 1]))
        ops.fix(500 + k, 0, 1)
        ops.equalDOF(k, 500 + k, 1)
    return 500 + k, k + 1


def _solver(ops, r):
    ops.constraints("Transformation")
    ops.numberer("Plain")
    ops.system("FullGeneral")
    ops.test("NormDispIncr", 1e-11, 100, 0)
    ops.algorithm("Newton")


if __name__ == "__main__":
    main(json.load(sys.stdin))
