"""The ground in an earthquake

Acceleration, velocity and displacement of El Centro 1940.
"""

import dampyr as dp
from dampyr.show.figures.ground_histories import ground_histories

motion = dp.ground_motions.el_centro()
ground_histories(motion.time, motion.acceleration, motion.velocity, motion.displacement)
