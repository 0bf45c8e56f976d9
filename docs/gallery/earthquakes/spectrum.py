"""A response spectrum

The peaks of oscillators over their period, at two dampings.
"""

import dampyr as dp

dp.ground_motions.spectrum(dp.ground_motions.el_centro(), damping=(0.02, 0.05)).plot()
