"""A synthetic earthquake

White noise, shaped by an envelope and by the ground; a seed is a motion.
"""

import dampyr as dp

dp.ground_motions.kanai_tajimi(20.0, 0.01, seed=1, pga=3.0).plot()
