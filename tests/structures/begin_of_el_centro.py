"""The beginning of El Centro, for tests that need no more."""

import numpy as np

from dampyr.ground_motions import GroundMotion, el_centro


def short(seconds: float, scale: float = 1.0) -> GroundMotion:
    """The first seconds of El Centro."""
    motion = el_centro()
    return GroundMotion(
        np.asarray(motion.acceleration)[: round(seconds / motion.dt) + 1] * scale,
        motion.dt,
        "start of El Centro",
    )
