"""Ground motions: El Centro 1940 built in, others read from PEER's .AT2, plain columns and MATLAB files.

``el_centro()``, ``read(path, units=..., dt=...)``, ``GroundMotion(acceleration, dt)`` and
``motion.scaled(1.5)``. A format is one file in ``formats/``.
"""

from dampyr.ground_motions.builtin import el_centro
from dampyr.ground_motions.motion import GroundMotion
from dampyr.ground_motions.reading import formats as known_formats
from dampyr.ground_motions.reading import read

__all__ = ["GroundMotion", "el_centro", "read", "known_formats"]
