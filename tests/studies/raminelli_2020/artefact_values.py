"""The only value of an artefact whose quantity begins in a certain way."""

from dampyr.studies.raminelli_2020 import ComparedValue
from dampyr.studies.raminelli_2020.study import Study
from dampyr.studies.raminelli_2020.study_part import StudyPart


def one(source: Study | StudyPart, artefact: str, start: str) -> ComparedValue:
    """The only value of an artefact whose quantity begins so."""
    matches = [f for f in source.compared if f.artefact == artefact and f.quantity.startswith(start)]
    assert len(matches) == 1, [f.quantity for f in source.compared if f.artefact == artefact]
    return matches[0]
