"""A record beside a design spectrum

El Centro scaled to the spectrum of EN 1998-1 between 0.2 and 2 s.
"""

import numpy as np

import dampyr as dp

gm = dp.ground_motions
design = gm.eurocode_8(ag=2.943, ground="C")
motion = gm.scaled_to_design(gm.el_centro(), design, 0.2, 2.0)
gm.compare_with_design(motion, design, np.geomspace(0.05, 4.0, 100)).plot()
