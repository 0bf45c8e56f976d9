"""A triple friction pendulum

A bearing that slides on one surface after the other, at two amplitudes.
"""

import numpy as np

import dampyr as dp
from dampyr.show.figures.loop_overlay import loop_overlay

t = np.linspace(0.0, 2.0, 2001)
numbers = {"f1": 150.0, "r2": 2.0, "r3": 3.0, "l1": 0.02, "l2": 0.04, "l3": 0.05, "d1": 0.02, "d2": 0.04, "d3": 0.1}
bearing = dp.Damper("triple_pendulum", numbers | {"uy": 1e-4})
paths = {f"{1e3 * a:g} mm": a * np.sin(2 * np.pi * t) for a in (0.015, 0.05, 0.12)}
loop_overlay({name: [(x, np.gradient(x, t), bearing.force(t, x))] for name, x in paths.items()})
