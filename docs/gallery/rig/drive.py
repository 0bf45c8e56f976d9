"""What the table and the coil are to do

Position, speed and voltage of one planned test.
"""

from dampyr import campaigns

step = {"kind": "earthquake", "motion": "el_centro", "voltage": "1.98 V"}
plan = campaigns.plan(campaigns.campaign_of({"name": "a day", "step": [step]}))
plan.tests[0].plot()
