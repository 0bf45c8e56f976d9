"""A study of three artefacts, made without a computation."""

from dampyr.show.pages.blocks import Text
from dampyr.studies._compared_value import ComparisonTolerance, Erratum, PrintedNumber, judge, unchecked
from dampyr.studies._study_run import compared_table
from dampyr.studies.raminelli_2020.study import Study
from dampyr.studies.raminelli_2020.study_part import StudyPart

CLOSE = ComparisonTolerance(relative=0.01)


def study() -> Study:
    """Table 1 with a number that agrees and one that differs, an equation, and a figure without files; one slip."""
    numbers = [
        judge("Table 1", "mean of a", PrintedNumber("2.000"), 2.0, "N", CLOSE),
        judge("Table 1", "mean of b", PrintedNumber("3.0"), 3.3, "N", CLOSE),
        judge("(2)", "coefficient", PrintedNumber("5"), 5.0, "", CLOSE),
    ]
    figure = [unchecked("Figure 3", "peak", PrintedNumber("-1.50"), "mm", "no files")]
    slip = Erratum("(9)", "-a", "+a", "the sign of (8)")
    parts = (
        StudyPart("Numbers", numbers, [compared_table(numbers)], [slip]),
        StudyPart("Pictures", figure, [Text("A picture is a picture.")]),
    )
    return Study(parts, None, ("all files",))
