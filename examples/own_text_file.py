"""A text file of one's own: millimetres, kilonewtons, decimal commas, and a coil current instead of a voltage.

The file is made here first, from a damper with kx = 1.5 N s/mm, kw = 200 N and rho = 20 per mm. It prints::

    0.45 A, 0.900 Hz, 16.00 mm peak to peak
    dahl.kx  1.50 N s/mm
    dahl.kw  200.00 N
    dahl.rho 20.00 1/mm
    offset   95.0 N
"""

from pathlib import Path

import numpy as np

import dampyr as dp
from dampyr.units import for_people

t = np.arange(0.0, 10.0, 0.005)
x = 0.008 * np.sin(2 * np.pi * 0.9 * t)
made_of = dp.models.Damper("dahl", {"dahl.kx": 1500.0, "dahl.kw": 200.0, "dahl.rho": 20e3})
force = 95.0 + made_of.force(t, x, voltage=0.0)
rows = np.column_stack([t, 1e3 * x, 1e-3 * force, np.full(t.size, 0.45)])
lines = [
    "t [s];Stroke LVDT [mm];Load cell [kN];i [A]",
    *(";".join(f"{v:.6f}" for v in row).replace(".", ",") for row in rows),
]
Path("test.csv").write_text("\n".join(lines))

record = dp.records.read("test.csv", columns={"displacement": "Stroke LVDT", "force": "Load cell"})
seen = dp.records.measure(record)
print(
    f"{record.input_value} {record.input}, {seen.frequency_hz:.3f} Hz, {1e3 * seen.peak_to_peak_m:.2f} mm peak to peak"
)
fit = dp.identification.fit(record, "dahl")
for name, value in fit.parameters.items():
    unit, factor = for_people(fit.units[name])
    print(f"{name:8} {value * factor:.2f} {unit}")
print(f"offset   {fit.nuisances['test'].offset:.1f} N")
