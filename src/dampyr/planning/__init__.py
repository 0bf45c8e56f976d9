"""The next tests: proposed by what they are expected to tell, performed on a rig, until the answer is known well enough.

`propose` chooses tests inside a rig's limits; `plan_and_perform` performs them round by round, fits and stops with a reason;
`choose_records` chooses among records that exist, by their motion alone.
"""

from dampyr.planning.goal import Peak
from dampyr.planning.planner import plan_and_perform
from dampyr.planning.proposal import PlanOptions, propose
from dampyr.planning.record_choice import choose_records

__all__ = [
    "Peak", "PlanOptions", "choose_records", "plan_and_perform", "propose",
]  # fmt: skip
