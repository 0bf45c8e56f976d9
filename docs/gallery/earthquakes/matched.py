"""A record matched to a design spectrum

El Centro scaled to the spectrum of EN 1998-1, and changed by wavelets until it has it.
"""

import dampyr as dp

gm = dp.ground_motions
gm.matched_to_design(gm.el_centro(), gm.eurocode_8(ag=2.943, ground="C"), 0.1, 4.0).plot()
