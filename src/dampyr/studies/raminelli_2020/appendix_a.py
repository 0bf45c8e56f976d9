"""Appendix A: the one number of the rig that the records can contradict."""

from __future__ import annotations

from dampyr.studies._compared_value import ComparedValue, Outcome, unchecked
from dampyr.studies._study_run import compared_table
from dampyr.studies.raminelli_2020.campaign_records import PublishedCampaign
from dampyr.studies.raminelli_2020.chapter_4_tables import FETCH
from dampyr.studies.raminelli_2020.published import Published
from dampyr.studies.raminelli_2020.study_part import StudyPart


def rig(published: Published, campaign: PublishedCampaign | None) -> StudyPart:
    """Table A.2: the actuator's speed without load against the speeds in the records."""
    quantity = "speed of the actuator (published: without load; ours: the highest in the records, under load)"
    if campaign is None or not campaign.tests:
        value = unchecked(
            "Table A.2", quantity, published.actuator_speed, "mm/s", f"needs the files; get them with {FETCH}"
        )
    else:
        fastest = max(campaign.tests, key=lambda test: test.measured.peak_speed)
        speed = 1e3 * fastest.measured.peak_speed
        possible = speed <= 1.1 * published.actuator_speed
        times = speed / published.actuator_speed
        reason = f"{fastest.record.name} moves at {times:.3g} times the printed speed; allowed: 1.1 times"
        outcome: Outcome = "agrees" if possible else "differs"
        value = ComparedValue("Table A.2", quantity, published.actuator_speed, speed, "mm/s", outcome, reason)
    return StudyPart("Table A.2: the rig", [value], [compared_table([value])])
