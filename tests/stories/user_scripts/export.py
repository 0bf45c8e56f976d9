"""Export my damper as C (and test it with its own vectors), as an FMU, and for OpenSees."""

import subprocess
from pathlib import Path

import dampyr as dp

damper = dp.models.Damper("dahl", {"dahl.kx": 1200.0, "dahl.kw": 180.0, "dahl.rho": 8000.0})
published = dp.studies.raminelli_2020.damper()
print(dp.export.available_kinds())

files = dp.export.export(published, "c", "controller", name="front")
print([path.name for path in files])
made = subprocess.run(["make", "test"], cwd="controller", capture_output=True, text=True)
print(made.returncode, (made.stdout + made.stderr).strip().splitlines()[-1])

[fmu] = dp.export.export(published, "fmu", "simulink", name="front")
print(fmu, Path(fmu).stat().st_size, "bytes")

files = dp.export.export(published, "opensees", "model", name="mr_damper", inputs=[0.0, 1.98])
print([path.name for path in files])
files = dp.export.export(damper, "opensees", "model", name="own")
print([path.name for path in files])
print(Path("model/own.tcl").read_text())
