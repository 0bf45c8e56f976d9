"""The tests that would tell most

Candidates among what the rig can do, and those that inform a damper most.
"""

import dampyr as dp

damper = dp.studies.raminelli_2020.damper()
dp.planning.propose(damper, tests=3, seconds=4.0).plot()
