"""A damper that loses force while it runs

The level of the force beside the card, followed sample by sample: the damper warms, and after 40 s a tenth is lost.
"""

import numpy as np

import dampyr as dp
from dampyr.show.figures import loop_overlay, style

damper, t = dp.studies.raminelli_2020.damper(), np.arange(0.0, 60.0, 0.01)
x, v = 0.008 * np.sin(3 * np.pi * t), 0.024 * np.pi * np.cos(3 * np.pi * t)
level = (1.0 - 0.001 * t) * np.where(t < 40.0, 1.0, 0.9)
force = level * damper.force(t, x, voltage=1.98, velocity=v)
tracked = dp.identification.track_level(damper, heat_capacity=450.0).along(0.01, x, v, force, 1.98)
curves = {"true": [(t[::200], level[::200])], "tracked": [(t[::200], tracked.level[::200])]}
loop_overlay.curve_overlay(curves, style.TIME, style.Axis("level of the force", "1"))
