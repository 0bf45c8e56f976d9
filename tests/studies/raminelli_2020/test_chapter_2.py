"""Section 2.4 and Figure 2.2 of Raminelli (2020): the known numbers come out, and a verdict follows its numbers."""

from dataclasses import replace

import pytest
from tests.studies.raminelli_2020.artefact_values import one

from dampyr.studies._compared_value import PrintedNumber
from dampyr.studies.raminelli_2020 import PUBLISHED
from dampyr.studies.raminelli_2020.chapter_2 import chapter_2
from dampyr.studies.raminelli_2020.study_part import StudyPart


class TestSection24:
    def test_the_example_is_recovered_and_the_printed_slope_is_the_nearest_samples(self, second: StudyPart) -> None:
        steps = "Section 2.4, steps 3 to 5"
        assert one(second, steps, "a of Step 4, exact").ours == pytest.approx(4457.6224, rel=1e-6)
        assert one(second, steps, "ρ of Step 1").ours == pytest.approx(705.32, rel=1e-6)
        assert one(second, steps, "a of Step 4, exact").verdict == "differs"
        sampled = one(second, steps, "a of Step 4, from the sample")
        assert (round(float(sampled.ours), 1), sampled.verdict) == (4466.3, "agrees")

    def test_step_2(self, second: StudyPart) -> None:
        assert {f.verdict for f in second.compared if f.artefact == "Section 2.4, step 2"} == {"agrees"}
        assert len([f for f in second.compared if f.artefact == "Section 2.4, step 2"]) == 5

    def test_figure_2_2(self, second: StudyPart) -> None:
        assert one(second, "Figure 2.2", "largest z").ours == pytest.approx(0.56512, abs=5e-6)

    @pytest.mark.prove
    def test_the_verdict_follows_the_printed_number(self) -> None:
        exact = replace(PUBLISHED, example=replace(PUBLISHED.example, a=PrintedNumber("4457.6")))
        assert one(chapter_2(exact), "Section 2.4, steps 3 to 5", "a of Step 4, exact").verdict == "agrees"

    @pytest.mark.prove
    def test_a_printed_number_that_no_phase_gives_is_told(self) -> None:
        far = replace(PUBLISHED, example=replace(PUBLISHED.example, a=PrintedNumber("4600.0")))
        value = one(chapter_2(far), "Section 2.4, steps 3 to 5", "a of Step 4, exact")
        assert "no phase" in value.reason
        assert "outside" in value.reason
