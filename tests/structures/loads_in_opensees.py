"""A linear shear building under forces on its floors and a ground motion in OpenSees, run as a script: JSON in, peaks as JSON
out. A process of its own, as a fault in OpenSees would end the tests.
"""

import json
import sys

import numpy as np
from opensees_module import opensees


def main(r):
    ops, n = opensees(), len(r["masses"])
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    for floor in range(n + 1):
        ops.node(floor, 0.0)
    ops.fix(0, 1)
    for k in range(n):
        ops.mass(k + 1, r["masses"][k])
        ops.uniaxialMaterial("Elastic", k + 1, r["stiffnesses"][k], r["dashpots"][k])
        ops.element("zeroLength", k + 1, k, k + 1, "-mat", k + 1, "-dir", 1)
    if r["steel"]:
        ops.uniaxialMaterial("Steel01", n + 1, *r["steel"])
        ops.element("zeroLength", n + 1, 0, 1, "-mat", n + 1, "-dir", 1)
    for number, (floor, force) in enumerate(r["forces"].items(), start=1):
        ops.timeSeries("Path", number, "-time", *r["time"], "-values", *force, "-useLast")
        ops.pattern("Plain", number, number)
        ops.load(int(floor), 1.0)
    if r["acceleration"]:
        ops.timeSeries("Path", 99, "-dt", r["dt"], "-values", *r["acceleration"])
        ops.pattern("UniformExcitation", 99, 1, "-accel", 99)
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("FullGeneral")
    ops.test("NormUnbalance", 1e-8 * r["stiffnesses"][0] * 1e-3, 50)
    ops.algorithm("Newton")
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")
    histories = []
    for _ in range(round(r["end"] / r["step"])):
        if ops.analyze(1, r["step"]) != 0:
            raise RuntimeError("OpenSees did not converge")
        histories.append([ops.nodeDisp(k, 1) for k in range(1, n + 1)])
    x = np.array(histories)
    drift = np.diff(x, axis=1, prepend=0.0)
    print(json.dumps({"displacement": np.abs(x).max(axis=0).tolist(), "drift": np.abs(drift).max(axis=0).tolist()}))


main(json.load(sys.stdin))
