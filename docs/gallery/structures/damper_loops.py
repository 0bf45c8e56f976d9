"""The damper's loops in a building

What the damper does while the building moves in El Centro 1940.
"""

import dampyr as dp
from dampyr.show.figures.loops import loops

S, damper = dp.structures, dp.studies.raminelli_2020.damper()
r = S.respond(S.two_storey(), dp.ground_motions.el_centro(), damper, voltage=1.98)
loops(r.drift[0], r.velocity[0], None, {"1.98 V": r.force[0]})
