"""A record over time

The force of one test as it was sampled.
"""

import numpy as np

import dampyr as dp

damper, t = dp.studies.raminelli_2020.damper(), np.arange(0.0, 6.0, 0.005)
x, v = 0.008 * np.sin(5.6 * t), 0.0448 * np.cos(5.6 * t)
noise = np.random.default_rng(1).normal(0.0, 8.0, t.size)
force = damper.force(t, x, voltage=1.98, velocity=v) + noise
record = dp.records.Record(t, x, force, voltage=1.98, velocity=v, name="sine")
record.plot.history("force")
