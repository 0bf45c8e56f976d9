"""Incremental dynamic analysis

The largest drift in each of 24 earthquakes as it is scaled up, and the fractiles over them.
"""

import numpy as np

import dampyr as dp

S, damper = dp.structures, dp.studies.raminelli_2020.damper()
motions = [dp.ground_motions.kanai_tajimi(15.0, 0.01, seed=(1, k), pga=3.0) for k in range(1, 25)]
scales = np.linspace(0.1, 2.5, 13)
S.ensemble(S.two_storey(), motions, damper, 1.98, scales=scales).plot.incremental()
