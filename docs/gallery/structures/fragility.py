"""Fragility of a building

How likely the drift of a storey exceeds 15 mm, over the intensity of the earthquake, with 90 % bands.
"""

import numpy as np

import dampyr as dp

S, damper = dp.structures, dp.studies.raminelli_2020.damper()
motions = [dp.ground_motions.kanai_tajimi(15.0, 0.01, seed=(1, k), pga=3.0) for k in range(1, 25)]
scales = np.linspace(0.1, 2.5, 13)
peaks = S.ensemble(S.two_storey(), motions, [None, damper], [0.0, 1.98], scales=scales, limits="15mm")
peaks.plot.fragility()
