"""A folder with what the examples of the commands name: a card, records, a rig, a campaign, motions, other files."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np

from dampyr import records
from dampyr.models import Damper, Polynomial
from dampyr.records import Record
from tests.campaigns.made_response import write_response
from tests.campaigns.specimen_folders import QUASI_STATIC, dahl, specimen_folder
from tests.ground_motions import accelerograph_files

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
BRIDGE = """
M = ["20 t", "20 t"]
K = { unit = "MN/m", values = [[9, -4, -5, 0], [-4, 11, 0, -7], [-5, 0, 5, 0], [0, -7, 0, 7]] }
damping_ratio = 0.02
supports = ["west", "east"]
"""


def fill_example_folder(folder: Path) -> None:
    """Write all of it into a folder that is there."""
    laws = {"kx": (800.0, 300.0), "kw": (40.0, 180.0), "rho": (4e4, -8e3)}
    damper = Damper("dahl", {f"dahl.{name}": Polynomial(numbers, 0.0, 3.0) for name, numbers in laws.items()})
    damper.save(folder / "damper.toml")
    (folder / "tests").mkdir()
    for k, (voltage, amplitude) in enumerate(
        [(u, a) for u in (0.0, 1.0, 1.98) for a in (0.006, 0.01)] + [(1.0, 0.008)]
    ):
        records.write(
            simulated(damper, voltage, amplitude, f"test {k + 1}", validation=k == 6),
            folder / "tests" / f"test {k + 1}.h5",
        )
    shutil.copytree(folder / "tests", folder / "lab" / "SN1")
    (folder / "rig.toml").write_text('[wires]\ncoil_current = "ai1"\n')
    shutil.copy(EXAMPLES / "quick_campaign.toml", folder / "campaign.toml")
    t = 0.02 * np.arange(500)
    np.savetxt(folder / "kobe.csv", 0.3 * np.sin(9.0 * t) * np.exp(-0.3 * t))
    (folder / "motions").mkdir()
    for k, stream in enumerate(("HNE", "HNN", "HNZ")):
        accelerograph_files.esm(folder / "motions" / f"{stream}.asc", accelerograph_files.shaking(seed=k), stream)
    specimen_folder(folder / "specimen-17", QUASI_STATIC, dahl(300.0, 4000.0))
    (folder / "design.toml").write_text('[[level]]\namplitude = "4 mm"\nlargest_force = "300 N"\nenergy = "4.5 J"\n')
    rows = [f"{a:.3f};{8 * np.sin(6 * a):.4f};{0.3 * np.tanh(5 * np.cos(6 * a)):.4f}" for a in 0.004 * np.arange(1500)]
    (folder / "test.csv").write_text("t [s];x [mm];Load cell [kN]\n" + "\n".join(rows).replace(".", ","))
    write_response(folder / "response", 0.01)
    (folder / "wind.csv").write_text("time [s],floor 1 [N],floor 2 [kN]\n0,0,0\n0.5,300,0.2\n1,100,0.5\n4,0,0\n")
    (folder / "bridge.toml").write_text(BRIDGE)
    (folder / "piers.toml").write_text('[west]\nmotion = "el_centro"\n[east]\nmotion = "el_centro"\nscale = 0.9\n')
    (folder / "limits.csv").write_text("quantity,high [ms]\nt63,20\n")


def simulated(damper: Damper, voltage: float, amplitude: float, name: str, validation: bool) -> Record:
    """A test of the damper, with noise of the load cell."""
    t = 0.005 * np.arange(1600)
    x = amplitude * np.sin(2.0 * np.pi * (0.5 + 50.0 * amplitude) * t)
    noise = np.random.default_rng(int(1e6 * amplitude)).normal(0.0, 1.0, t.size)
    return Record(
        t,
        x,
        damper.force(t, x, voltage=voltage) + noise,
        voltage=voltage,
        name=name,
        role="validation" if validation else "fit",
    )
