"""A test on the simulated rig

The table, the sensors and the damper are simulated; the record is read as one of a real rig would be.
"""

import tempfile

import dampyr as dp

step = {"kind": "sine", "amplitude": "8 mm", "frequency": "1 Hz", "voltage": "1.98 V", "cycles": 4}
plan = dp.campaigns.plan(dp.campaigns.campaign_of({"name": "one test", "step": [step]}))
with tempfile.TemporaryDirectory() as folder, dp.rig.simulated() as rig:
    [record] = dp.campaigns.perform(plan, rig, folder)
record.plot.loops()
