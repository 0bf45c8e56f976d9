"""Loops of a damper at several voltages

Force over displacement and over velocity of the published damper of Raminelli (2020) on a sine.
"""

import dampyr as dp

damper = dp.studies.raminelli_2020.damper()
damper.plot.loops([0.0, 0.8712, 1.98, 3.212], amplitude=0.008, frequency=0.9)
