"""A hybrid test of a heavy building on the simulated rig."""

from pathlib import Path

from dampyr.campaigns import hybrid_result, perform, planned_hybrid
from dampyr.hybrid.hybrid_result import HybridResult
from dampyr.rig import Rig

HEAVY = """name = "two storeys of 1.5 t"
masses = ["1.458 t", "1.458 t"]
stiffnesses = ["655.5 kN/m", "655.5 kN/m"]
damping_ratio = 0.03
"""


def heavy(folder: Path) -> str:
    path = folder / "heavy.toml"
    path.write_text(HEAVY)
    return str(path)


def settings(folder: Path, **changes: object) -> dict[str, object]:
    step = {
        "kind": "hybrid",
        "structure": heavy(folder),
        "voltage": 0.8712,
        "duration": 4.0,
        "scale": 0.15,
        "rest_before": "0.2 s",
    }
    return step | changes


def run(folder: Path, rig: Rig, **changes: object) -> HybridResult:
    planned = planned_hybrid(settings(folder, **changes))
    planned.require()
    perform(planned, rig, folder / "out")
    return hybrid_result(folder / "out" / f"{planned.tests[0].name}.h5")
