"""How the parameters follow the voltage

The laws of a damper over the voltage at its coil, inside the calibrated range.
"""

import dampyr as dp

dp.studies.raminelli_2020.damper().plot.laws()
