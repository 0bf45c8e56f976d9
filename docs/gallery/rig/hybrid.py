"""A virtual hybrid test

The building is computed while a part of its first storey stands in a simulated machine; beside it the structure in one piece.
"""

import dampyr as dp
from dampyr import hybrid

setup = hybrid.HybridSetup(dp.studies.vrths_2020.structure(4))
motion = dp.ground_motions.el_centro().scaled(0.4)
hybrid.perform_virtual(setup, hybrid.KalmanCompensator.designed(setup), motion).plot()
