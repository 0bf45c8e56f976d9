"""A building with and without a damper

The roof of the two-storey building in El Centro 1940, without the damper, with it off, and on.
"""

import dampyr as dp

S, damper = dp.structures, dp.studies.raminelli_2020.damper()
S.respond(S.two_storey(), dp.ground_motions.el_centro(), damper, voltage=[0.0, 1.98]).plot.history()
