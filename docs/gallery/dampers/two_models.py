"""Two models of friction over one another

Dahl's model, and a Bouc-Wen model whose corner is sharper and whose return is softer, along the same path.
"""

import numpy as np

import dampyr as dp
from dampyr.show.figures.loops import loops

t = np.linspace(0.0, 3.0, 1501)
x, v = 0.008 * np.sin(2 * np.pi * t), 0.016 * np.pi * np.cos(2 * np.pi * t)
dahl = dp.Damper("dahl", {"kx": 1000.0, "kw": 300.0, "rho": 1000.0})
numbers = {"c0": 1000.0, "k0": 0.0, "kw": 300.0, "rho": 1000.0, "sigma": 2.0, "n": 3.0}
bouc_wen = dp.Damper("bouc_wen", numbers)
loops(x, v, None, {"Dahl": dahl.force(t, x), "Bouc-Wen, n = 3": bouc_wen.force(t, x)})
