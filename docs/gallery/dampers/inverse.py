"""The voltage that gives a wanted force

A skyhook-like force is asked of the damper along a path; it is met wherever it can be.
"""

import numpy as np

import dampyr as dp
from dampyr.show.figures.control_comparison import controlled
from dampyr.show.figures.style import FORCE

t = np.linspace(0.0, 4.0, 2001)
x, v = 0.008 * np.sin(2 * np.pi * t), 0.016 * np.pi * np.cos(2 * np.pi * t)
wanted = 8000.0 * v * np.sin(np.pi * t / 4) ** 2
found = dp.studies.raminelli_2020.damper().inverse().along(t, x, wanted, velocity=v)
controlled(t, {"wanted": wanted, "given": found.force}, {"given": found.input}, FORCE)
