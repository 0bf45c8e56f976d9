"""A leaderboard of models

Every model is tried, bare and with the add-ons that are worth it.
"""

import numpy as np

import dampyr as dp

damper, t, records = dp.studies.raminelli_2020.damper(), np.arange(0.0, 5.0, 0.01), []
noise = np.random.default_rng(1)
for u, a, f in [(u, a, f) for u in (0.0, 0.9, 1.8, 2.7) for a, f in ((4, 1.2), (7, 0.9), (10, 0.6))]:
    x = 1e-3 * a * np.sin(2 * np.pi * f * t)
    force = damper.force(t, x, voltage=u) * noise.normal(1.0, 0.03) + noise.normal(0.0, 6.0, t.size)
    records.append(dp.records.Record(t, x, force, voltage=u, name=f"{a} mm at {u} V"))
dp.fit(records, models=["dahl", "bingham", "hyperbolic_tangent"]).leaderboard.plot()
