"""The cycles of three tests over one another

A yielding device at three strokes, cut into full cycles.
"""

import numpy as np

import dampyr as dp

t = np.linspace(0.0, 6.0, 2401)
device = dp.Damper("bilinear", {"Q": 900.0, "uy": 0.001, "k2": 1e5})
paths = {f"{a} mm": 1e-3 * a * np.sin(2 * np.pi * t) for a in (5, 10, 20)}
records = [dp.records.Record(t, x, device.force(t, x), name=n, no_input=True) for n, x in paths.items()]
dp.records.cycles(records).plot()
