"""Chapter 5's building in OpenSees under El Centro, run as a script: JSON in (see `build`), the peaks as JSON out.

A process of its own: a fault in OpenSees ends it and not the tests, and the damper's server is another process.
"""

import importlib
import importlib.util
import json
import sys
import time

GROUND, FIRST, ROOF = 0, 1, 2


def opensees():
    for name in ("openseespylinux.opensees", "openseespy.opensees"):
        try:
            return importlib.import_module(name)
        except (ImportError, RuntimeError):
            continue
    raise ImportError("OpenSees cannot be loaded")


def main(request):
    ops = opensees()
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    for node in (GROUND, FIRST, ROOF):
        ops.node(node, 0.0)
    ops.fix(GROUND, 1)
    for node, mass in zip((FIRST, ROOF), request["masses"], strict=True):
        ops.mass(node, mass)
    for tag, (ends, (k, c)) in enumerate(
        zip(((GROUND, FIRST), (FIRST, ROOF), (GROUND, ROOF)), request["pairs"], strict=True), 1
    ):
        ops.uniaxialMaterial("Elastic", tag, k, c)
        ops.element("zeroLength", tag, *ends, "-mat", tag, "-dir", 1)
    if "text" in request:
        spec = importlib.util.spec_from_file_location("damper", request["text"])
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        module.define(ops, 100, request["voltage"])
        ops.element("zeroLength", 10, GROUND, FIRST, "-mat", 100, "-dir", 1)
    if "port" in request:
        nodes = request["nodes"]
        dofs = [word for _ in nodes for word in ("-dof", 1)]
        ops.element("genericClient", 10, "-node", *nodes, *dofs, "-server", request["port"])
    ops.timeSeries("Path", 1, "-dt", request["dt"], "-values", *request["acceleration"])
    ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("FullGeneral")
    ops.test("NormDispIncr", request.get("tolerance", 1e-9), 50, 0)
    ops.algorithm("Newton")
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")
    steps = round((len(request["acceleration"]) - 1) * request["dt"] / request["step"])
    peaks, iterations, failed, start = [0.0, 0.0], 0, 0, time.perf_counter()
    for _ in range(steps):
        failed = ops.analyze(1, request["step"])
        if failed:
            break
        iterations += ops.testIter()
        for k, node in enumerate((FIRST, ROOF)):
            peaks[k] = max(peaks[k], abs(ops.nodeDisp(node, 1)))
    took = time.perf_counter() - start
    ops.wipe()
    return {"peaks": peaks, "iterations": iterations / steps, "steps_per_s": steps / took, "failed": failed}


if __name__ == "__main__":
    print(json.dumps(main(json.load(sys.stdin))))
