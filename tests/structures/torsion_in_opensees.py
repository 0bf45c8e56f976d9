"""Floors that turn in OpenSees, in plan: run as a script, JSON in, peaks as JSON out. A process of its own, as a fault in
OpenSees would end the tests.

Each floor is a node at its centre of mass, free along x and to turn, with rigid arms to its frames; all floors lie in
one plane.
"""

import json
import sys

import numpy as np
from opensees_module import opensees


def main(r):
    ops, n = opensees(), len(r["masses"])
    ops.wipe()
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    # in OpenSees' plan the frame at y lies at (0, -y): a turn moves a point along x by -theta times its ordinate
    places = sorted({float(y) for y in r["frames"]} | {r["steel_at"]})
    for floor in range(n + 1):
        centre = 0.0 if floor == 0 else -r["centres"][floor - 1]
        ops.node(1000 * floor, 0.0, centre)
        for k, y in enumerate(places):
            ops.node(1000 * floor + 1 + k, 0.0, -y)
        if floor == 0:
            for k in range(len(places) + 1):
                ops.fix(k, 1, 1, 1)
        else:
            ops.fix(1000 * floor, 0, 1, 0)
            ops.mass(1000 * floor, r["masses"][floor - 1], 1e-9, r["inertias"][floor - 1])
            for k in range(len(places)):
                ops.rigidLink("beam", 1000 * floor, 1000 * floor + 1 + k)
    tag = 0
    for floor in range(1, n + 1):
        for k, y in enumerate(places):
            springs = [value for at, value in r["frames"].items() if float(at) == y]
            for spring in springs:
                tag += 1
                ops.uniaxialMaterial("Elastic", tag, spring, r["beta"] * spring)
                ops.element(
                    "zeroLength", tag, 1000 * floor - 1000 + 1 + k, 1000 * floor + 1 + k, "-mat", tag, "-dir", 1
                )
            if y == r["steel_at"] and floor == 1:
                tag += 1
                ops.uniaxialMaterial("Steel01", tag, *r["steel"])
                ops.element("zeroLength", tag, 1 + k, 1001 + k, "-mat", tag, "-dir", 1)
    ops.timeSeries("Path", 1, "-dt", r["dt"], "-values", *r["acceleration"])
    ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
    ops.constraints("Penalty", 1e13, 1e13)  # under "Transformation" the dashpots between tied nodes do not act
    ops.numberer("Plain")
    ops.system("FullGeneral")
    ops.test("NormDispIncr", 1e-11, 100, 0)
    ops.algorithm("Newton")
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")
    histories = []
    for _ in range(round((len(r["acceleration"]) - 1) * r["dt"] / r["step"])):
        if ops.analyze(1, r["step"]) != 0:
            raise RuntimeError("OpenSees did not converge")
        histories.append([[ops.nodeDisp(1000 * k, 1), ops.nodeDisp(1000 * k, 3)] for k in range(1, n + 1)])
    x, theta = np.moveaxis(np.array(histories), 2, 0)
    ends = {y: x + (y - np.array(r["centres"])) * theta for y in r["lines"]}
    drift = {y: np.abs(np.diff(u, axis=1, prepend=0.0)).max(axis=0).tolist() for y, u in ends.items()}
    print(json.dumps({"drift": list(drift.values()), "turn": np.abs(theta).max(axis=0).tolist()}))


main(json.load(sys.stdin))
