"""A storey that yields

The drift of the first storey: what remains after the earthquake, with a damper beside the yielding storey and without.
"""

import dampyr as dp
from dampyr.show.figures.building import building_response

S, damper = dp.structures, dp.studies.raminelli_2020.damper()
building, storeys = S.yielding_shear_building([250.0, 200.0], [120e3, 90e3], yield_drifts=0.01, damping_ratio=0.02)
motion = dp.ground_motions.el_centro()
bare = S.respond(building, motion, storeys, after=10.0)
held = S.respond(building, motion, storeys | {1: [storeys[1], damper]}, voltage=1.98, after=10.0)
building_response(bare.time, {"bare": bare.drift[0], "with a damper": held.drift[0]})
