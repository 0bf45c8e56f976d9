"""Strengths for a ductility

How strong an oscillator must be under El Centro so that it yields no further.
"""

import numpy as np

import dampyr as dp

gm = dp.ground_motions
gm.inelastic_spectrum(gm.el_centro(), [1.0, 2.0, 4.0], np.geomspace(0.1, 4.0, 60)).plot()
