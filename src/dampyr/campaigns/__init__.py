"""What to run: campaigns of tests, planned and checked before anything moves.

::

    tests = plan("campaign.toml", "rig.toml")  # every test with its duration, peaks and expected force
    tests.refusals                             # what the rig cannot do, each with the largest value that it can

A kind of step is one file in the package ``dampyr.campaigns.steps``; `available_steps` lists them.
"""

from dampyr.campaigns.campaign import Campaign, Header, Test, campaign_of, read
from dampyr.campaigns.check import Violation, largest, violations_of
from dampyr.campaigns.force_prediction import envelope, specimen
from dampyr.campaigns.hybrid_campaign import hybrid_result, planned_hybrid
from dampyr.campaigns.journal import Journal, read_journal
from dampyr.campaigns.kinds import available_steps, kind
from dampyr.campaigns.performing import perform
from dampyr.campaigns.planned_tests import Plan, PlannedTest, plan
from dampyr.campaigns.recorded_campaign import RecordedCampaign
from dampyr.campaigns.run_control import Progress, RunControl, Skipped, Stopped, exit_status
from dampyr.campaigns.step import Peaks, Step

__all__ = [
    "Campaign",
    "Header",
    "Test",
    "read",
    "campaign_of",
    "kind",
    "available_steps",
    "Step",
    "Peaks",
    "Plan",
    "PlannedTest",
    "plan",
    "planned_hybrid",
    "hybrid_result",
    "Violation",
    "violations_of",
    "largest",
    "perform",
    "RecordedCampaign",
    "RunControl",
    "Progress",
    "Skipped",
    "Stopped",
    "exit_status",
    "Journal",
    "read_journal",
    "specimen",
    "envelope",
]
