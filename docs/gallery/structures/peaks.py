"""Peaks by floor

Displacement, drift and acceleration of each floor at several voltages.
"""

import dampyr as dp

S, damper = dp.structures, dp.studies.raminelli_2020.damper()
S.respond(S.two_storey(), dp.ground_motions.el_centro(), damper, voltage=[0.0, 1.0, 3.212]).plot.peaks()
