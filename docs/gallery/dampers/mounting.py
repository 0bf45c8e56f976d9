"""A soft mounting and free play in it

What lies between the damper and the machine turns the loop: a compliance leans it, free play cuts it.
"""

import numpy as np

import dampyr as dp
from dampyr.show.figures.loops import loops

t = np.linspace(0.0, 3.0, 3001)
x, v = 0.008 * np.sin(2 * np.pi * t), 0.016 * np.pi * np.cos(2 * np.pi * t)
numbers = {"dahl.kx": 1000.0, "dahl.kw": 300.0, "dahl.rho": 3000.0}
soft = dp.Damper("dahl + compliance", numbers | {"compliance.s": 5e-6})
loose = dp.Damper("dahl + free_play", numbers | {"free_play.g": 0.002, "free_play.fc": 20.0})
dampers = {"rigid": dp.Damper("dahl", numbers), "compliance": soft, "free play": loose}
loops(x, v, None, {name: damper.force(t, x) for name, damper in dampers.items()})
