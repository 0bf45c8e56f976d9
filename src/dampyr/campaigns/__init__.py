"""What to run: campaigns of tests, planned and checked before anything moves.

::

    tests = plan("campaign.toml", "rig.toml")  # every test with its duration, peaks and expected force
    tests.refusals                             # what the rig cannot do, each with the largest value that it can

`judge` says whether specimens hold criteria on every level that their campaigns asked, `judge_protocol` whether the figures
of a protocol lie within a sheet of limits.

A kind of step is one file in the package ``dampyr.campaigns.steps``; `available_steps` lists them.
"""

from dampyr.campaigns.campaign import Campaign, campaign_of, read
from dampyr.campaigns.campaign_thresholds import CampaignThresholds
from dampyr.campaigns.hybrid_campaign import hybrid_result, planned_hybrid
from dampyr.campaigns.journal import Journal, read_journal
from dampyr.campaigns.judgement import judge
from dampyr.campaigns.kinds import available_steps
from dampyr.campaigns.performing import perform
from dampyr.campaigns.planned_tests import Plan, plan
from dampyr.campaigns.protocol_result import judge_protocol
from dampyr.campaigns.recorded_campaign import RecordedCampaign
from dampyr.campaigns.run_control import RunControl, Stopped

__all__ = [
    "Campaign", "read", "campaign_of", "available_steps", "Plan", "plan", "planned_hybrid", "hybrid_result", "perform",
    "RecordedCampaign", "RunControl", "Stopped", "Journal", "read_journal", "CampaignThresholds", "judge",
    "judge_protocol",
]  # fmt: skip
