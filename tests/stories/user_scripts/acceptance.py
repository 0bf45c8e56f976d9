"""Judge records of two specimens against a reference damper: a good one passes, a weak one fails."""

from pathlib import Path

import numpy as np

import dampyr as dp
from dampyr.show import write_page

reference = dp.studies.raminelli_2020.damper()
rng = np.random.default_rng(4)
t = np.arange(0.0, 10.0, 0.005)
x = 0.008 * np.sin(2 * np.pi * 0.9 * t)
records = []
for name, factor in (("good", 1.03), ("weak", 0.6)):
    force = 100.0 + factor * reference.force(t, x, voltage=1.98) + rng.normal(0.0, 4.0, t.size)
    records.append(dp.records.Record(t, x, force, voltage=1.98, name=name, specimen=name))

accepted = dp.identification.accept(records, reference, tolerance="15%", force_slack="10 N")
for record, result in zip(records, accepted.results):
    worst = result.worst
    print(f"{record.name}: {result.verdict}, {len(result.outside)} of {len(result.judged)} outside,", end=" ")
    print(f"worst {worst.quantity} in cycle {worst.cycle}, off by {worst.deviation:+.1%}")
print(accepted)
print(write_page(accepted, Path("acceptance.html")))
