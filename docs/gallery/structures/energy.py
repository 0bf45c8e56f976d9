"""Where the energy goes

What the earthquake puts in, and what the damper and the structure take.
"""

import dampyr as dp

S, damper = dp.structures, dp.studies.raminelli_2020.damper()
S.respond(S.two_storey(), dp.ground_motions.el_centro(), damper, voltage=1.98).plot.energy()
