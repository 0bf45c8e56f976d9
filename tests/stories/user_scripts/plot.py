"""Draw the loops of a record and of a fit as PNG, and write the page of the fit as HTML."""

from pathlib import Path

import numpy as np

import dampyr as dp
from dampyr.show import made_by, write_page

rng = np.random.default_rng(2)
t = np.arange(0.0, 8.0, 0.005)
true = dp.studies.raminelli_2020.damper()
records = []
for voltage in (0.0, 1.98):
    for amplitude, frequency in ((0.005, 1.2), (0.008, 0.9), (0.011, 0.6)):
        x = amplitude * np.sin(2 * np.pi * frequency * t)
        force = true.force(t, x, voltage=voltage) + rng.normal(0.0, 3.0, t.size)
        name = f"{1e3 * amplitude:g}mm {voltage:g}V"
        records.append(dp.records.Record(t, x, force, voltage=voltage, name=name))
fit = dp.identification.fit(records, "dahl")


def save(axes, name):
    np.ravel(axes)[0].figure.savefig(name, dpi=120)
    print(name, Path(name).stat().st_size, "bytes")


save(records[4].plot.loops(), "record.png")
save(fit.plot.loops(records[4]), "fit.png")
with made_by("plot.py"):
    page = write_page(fit, Path("fit.html"))
print(page, page.stat().st_size, "bytes")
