"""Which control law is better, and how sure that is

In how many of the same cases each input gives the least drift, with the band of a bootstrap over the earthquakes.
"""

import dampyr as dp

S, damper = dp.structures, dp.studies.raminelli_2020.damper()
motions = [dp.ground_motions.kanai_tajimi(15.0, 0.01, seed=(1, k), pga=3.0) for k in range(1, 13)]
laws = [S.control_law(name, high=3.212, lag=0.01) for name in ("on_off", "clipped_optimal")]
S.arena(S.ensemble(S.two_storey(), motions, damper, [3.212, *laws]), "acceleration").plot()
