"""A corner plot of the posterior

Samples of the numbers of a fit, each beside each other one.
"""

import numpy as np

import dampyr as dp

damper, t, records = dp.studies.raminelli_2020.damper(), np.arange(0.0, 5.0, 0.01), []
noise = np.random.default_rng(1)
for a, f in [(a, f) for a in (4, 7, 10) for f in (0.6, 0.9, 1.2)]:
    x = 1e-3 * a * np.sin(2 * np.pi * f * t)
    force = damper.force(t, x, voltage=0.9) * noise.normal(1.0, 0.03) + noise.normal(0.0, 6.0, t.size)
    records.append(dp.records.Record(t, x, force, voltage=0.9, name=f"{a} mm, {f} Hz"))
dp.identification.sample_posterior(dp.fit(records, "dahl"), lengths=20, seed=1).plot.corner()
