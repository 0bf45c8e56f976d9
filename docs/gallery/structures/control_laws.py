"""Control laws in the same earthquake

The drift of the second storey under two control laws, and the voltage that each of them asks for.
"""

import dampyr as dp
from dampyr.show.figures.control_comparison import controlled
from dampyr.show.figures.style import Axis

S, damper = dp.structures, dp.studies.raminelli_2020.damper()
laws = {n: S.control_law(n, high=3.212, lag=0.01) for n in ("on_off", "clipped_optimal")}
motion = dp.ground_motions.trimmed(dp.ground_motions.el_centro(), 0.01, 0.6)
found = {n: S.respond(S.two_storey(), motion, damper, voltage=u) for n, u in ({"0 V": 0.0} | laws).items()}
inputs, drifts = {n: found[n].input[0] for n in laws}, {n: r.drift[1] for n, r in found.items()}
controlled(motion.time, drifts, inputs, Axis("drift of storey 2", "mm", 1e3))
