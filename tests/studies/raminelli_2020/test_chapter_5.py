"""Chapter 5 of Raminelli (2020): peaks, percentages, a likely slip of units, and a sign."""

from dataclasses import replace

import pytest
from tests.studies.raminelli_2020.artefact_values import one

from dampyr.studies._compared_value import PrintedNumber
from dampyr.studies.raminelli_2020 import PUBLISHED
from dampyr.studies.raminelli_2020.chapter_5 import chapter_5
from dampyr.studies.raminelli_2020.study_part import StudyPart


class TestChapter5:
    def test_the_peaks(self, fifth: StudyPart) -> None:
        for case, peak in (("case 1", 45.5340), ("case 2", 27.2081), ("case 3", 3.5215)):
            value = one(fifth, "Figure 5.4", f"peak of the first floor, {case}")
            assert (value.ours, value.verdict) == (pytest.approx(peak, rel=2e-4), "differs")
        assert "4.9005" in one(fifth, "Figure 5.4", "peak of the first floor, case 1").reason

    def test_the_unit_slip_is_likely_and_not_proven(self, fifth: StudyPart) -> None:
        value = one(fifth, "Figure 5.4", "a unit slip")
        assert "likely, not proven" in value.quantity
        two, three = (float(word) for word in str(value.ours).replace(" mm", "").split(" and "))
        assert (two, three) == (pytest.approx(216.34, abs=0.05), pytest.approx(219.79, abs=0.05))

    def test_the_percentages_from_the_printed_peaks(self, fifth: StudyPart) -> None:
        compared = [one(fifth, "Section 5.2", f"reduction in case {k}") for k in (2, 3)]
        assert [round(float(f.ours), 2) for f in compared] == [2.82, 9.69]
        assert {f.verdict for f in compared} == {"differs"}

    def test_the_sign_of_the_output(self, fifth: StudyPart) -> None:
        erratum = next(e for e in fifth.errata if e.place == "(5.6)")
        assert erratum.correct == "D_y = +M⁻¹Λ"

    def test_other_printed_peaks_change_the_verdicts(self) -> None:
        peaks = (PrintedNumber("45.5340"), PrintedNumber("27.2080"), PrintedNumber("201.5243"))
        fifth = chapter_5(replace(PUBLISHED, peaks=peaks, reductions=(PrintedNumber("40.25"), PrintedNumber("13.66"))))
        assert one(fifth, "Figure 5.4", "peak of the first floor, case 1").verdict == "agrees"
        assert one(fifth, "Figure 5.4", "peak of the first floor, case 2").verdict == "agrees"
        assert one(fifth, "Figure 5.4", "peak of the first floor, case 3").verdict == "differs"
        assert one(fifth, "Section 5.2", "reduction in case 2").verdict == "agrees"
        assert "not supported" in one(fifth, "Figure 5.4", "a unit slip").quantity
