"""Effective stiffness over the stroke

A figure of every cycle, drawn over another one: the secant stiffness of a yielding device falls with its stroke.
"""

import numpy as np

import dampyr as dp
from dampyr.show.figures import envelope, loop_overlay, style

t = np.linspace(0.0, 6.0, 2401)
device = dp.Damper("bilinear", {"Q": 900.0, "uy": 0.001, "k2": 1e5})
paths = [a * np.sin(2 * np.pi * t) for a in (0.002, 0.003, 0.005, 0.01, 0.015, 0.02)]
records = [dp.records.Record(t, x, device.force(t, x), no_input=True) for x in paths]
steady = [figures.cycles[2] for figures in dp.records.cycles(records)]
curves = {"cycle 3": [([c.amplitude for c in steady], [c.effective_stiffness for c in steady])]}
loop_overlay.curve_overlay(curves, envelope.AMPLITUDE, style.Axis("stiffness", "N/mm", 1e-3), zero=True)
