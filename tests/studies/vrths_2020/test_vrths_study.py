"""Silva et al. (2020), MSSP 135, 106381: the replica's table, the aims, planted errors."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import dampyr as dp
from dampyr.errors import InputError, MissingData
from dampyr.ground_motions import GroundMotion
from dampyr.hybrid import (
    HybridSetup,
    KalmanCompensator,
    PhaseLeadCompensator,
    loop_stability,
    perform_virtual,
    run_many,
)
from dampyr.hybrid.criteria import CRITERIA
from dampyr.studies import vrths_2020
from dampyr.studies.vrths_2020.vrths_study import (
    COMMAND_ONLY,
    IN_TIME,
    OURS,
    PHASE_LEAD,
    PUBLISHED_ADAPTIVE,
    REPLICA,
    arrangements,
    set_up,
)

CASES = pytest.mark.parametrize(
    "case", [case if case == 4 else pytest.param(case, marks=pytest.mark.prove) for case in vrths_2020.CASES]
)


def within_3_percent(name: str, case: int, own: np.ndarray) -> bool:
    return bool(np.all(np.abs(own - REPLICA[name, case]) <= 0.03 * np.abs(REPLICA[name, case])))


class TestTheSampleController:
    @pytest.mark.prove
    @CASES
    def test_all_criteria_are_the_replicas_within_3_percent(self, el_centro: GroundMotion, case: int) -> None:
        run = perform_virtual(*arrangements(case)[PHASE_LEAD], el_centro)
        own = np.array(run.criteria())
        assert within_3_percent(PHASE_LEAD, case, own), dict(zip(CRITERIA, own, strict=True))
        assert run.at_limit == 0

    @pytest.mark.parametrize(
        "planted",
        [
            "force in time",
            "gain",
            "damping",
            *(
                pytest.param(error, marks=pytest.mark.prove)
                for error in ("two samples late", "beta2", "lead", "kp", "stiffness")
            ),
        ],
    )
    def test_a_planted_error_is_noticed(self, el_centro: GroundMotion, planted: str) -> None:
        """Each would pass a look at J1 and J2 alone, or at all but a few criteria."""
        setup, compensator = set_up(4), PhaseLeadCompensator()
        transfer = setup.transfer
        structure = vrths_2020.structure(4)
        changed: dict[str, tuple[HybridSetup, PhaseLeadCompensator]] = {
            "force in time": (replace(setup, force_delay=0), compensator),
            "two samples late": (replace(setup, force_delay=2), compensator),
            "gain": (replace(setup, transfer=replace(transfer, gain=1.0)), compensator),
            "beta2": (replace(setup, transfer=replace(transfer, beta2=1.04 * transfer.beta2)), compensator),
            "lead": (setup, replace(compensator, lead=49.0)),
            "kp": (setup, replace(compensator, kp=2.1)),
            "stiffness": (setup.with_plant(1.26e6, transfer.pole, transfer.beta1, transfer.beta2), compensator),
            "damping": (
                replace(setup, structure=dp.structures.Building(structure.M, 1.1 * structure.C, structure.K)),
                compensator,
            ),
        }
        own = np.array(perform_virtual(*changed[planted], el_centro).criteria())
        assert not within_3_percent(PHASE_LEAD, 4, own)


class TestThePublishedAdaptiveCompensator:
    @pytest.mark.prove
    @pytest.mark.parametrize("case", [1, 4])
    def test_the_replicas_one_draw_is_within_the_spread_of_ours(self, el_centro: GroundMotion, case: int) -> None:
        """The noise alone moves these criteria by 4 to 13 %: the replica's draw is held against the mean of twelve."""
        setup, compensator = arrangements(case)[PUBLISHED_ADAPTIVE]
        draws = np.array([perform_virtual(setup, compensator, el_centro, seed).criteria() for seed in range(12)])
        mean, spread = draws.mean(axis=0), draws.std(axis=0)
        gap = np.abs(mean - REPLICA[PUBLISHED_ADAPTIVE, case])
        assert np.all(gap <= 0.03 * np.array(REPLICA[PUBLISHED_ADAPTIVE, case]) + 2.0 * spread)
        assert np.all(spread[1:] < 0.2 * mean[1:])

    def test_with_the_force_late_its_floors_are_twice_as_wrong(self, el_centro: GroundMotion) -> None:
        in_time, compensator = arrangements(4)[PUBLISHED_ADAPTIVE]
        J4 = [perform_virtual(s, compensator, el_centro).criteria().J4 for s in (in_time, set_up(4))]
        assert J4[0] < 1.3
        assert J4[1] == pytest.approx(3.09, abs=0.2)

    def test_the_measured_displacement_shows_mostly_the_noise(self, el_centro: GroundMotion) -> None:
        run = perform_virtual(*arrangements(1)[PUBLISHED_ADAPTIVE], el_centro)
        true, measured = run.criteria(), run.criteria(measured=True)
        assert measured[1] == pytest.approx(2.57, rel=0.03)
        assert true[1] < 0.45


class TestOurCompensator:
    @CASES
    def test_the_aims_are_met_with_the_force_late(self, el_centro: GroundMotion, case: int) -> None:
        criteria = perform_virtual(*arrangements(case)[OURS], el_centro).criteria()
        assert criteria.J1 == 0.0
        assert criteria.J2 < 0.15
        assert max(criteria[3:]) < 0.35

    @pytest.mark.parametrize("case", [pytest.param(1, marks=pytest.mark.prove), 4])
    def test_on_the_command_alone_they_need_the_force_in_time(self, el_centro: GroundMotion, case: int) -> None:
        in_time, late = (
            perform_virtual(*arrangements(case)[name], el_centro).criteria() for name in (IN_TIME, COMMAND_ONLY)
        )
        assert in_time.J2 < 0.4
        assert in_time.J4 < 0.5
        assert late.J2 < 0.4
        assert late.J4 > 1.0

    @pytest.mark.prove
    def test_under_kobe(self, motions: Path) -> None:
        kobe = vrths_2020.motion("Kobe", motions)
        criteria = perform_virtual(*arrangements(4)[OURS], kobe).criteria()
        assert criteria.J2 < 0.15
        assert criteria.J4 < 0.35

    def test_a_nominal_plant_that_is_wrong_is_learned(self, el_centro: GroundMotion) -> None:
        """Without learning the same start gives ten times the error."""
        setup = set_up(1)
        wrong = setup.with_plant(1.34e6, 5.9, 430.0, 1.07e5)
        learning = KalmanCompensator.designed(setup)
        fixed = replace(learning, covariance=tuple((0.0,) * 4 for _ in range(4)))
        own, other = (perform_virtual(wrong, each, el_centro).criteria().J2 for each in (learning, fixed))
        assert own < 0.3
        assert other > 5 * own


class TestRandomPlants:
    def test_none_of_a_few_is_unstable(self, el_centro: GroundMotion) -> None:
        setup, compensator = arrangements(4)[OURS]
        batch = run_many(setup, compensator, el_centro, 4)
        assert batch.unstable == 0
        assert np.all(batch.true[:, 1] < 0.4)
        assert np.all(batch.true[:, 3] < 1.0)

    @pytest.mark.prove
    @pytest.mark.endure
    @pytest.mark.parametrize("case", vrths_2020.CASES)
    def test_none_of_a_thousand_is(self, el_centro: GroundMotion, case: int, request: pytest.FixtureRequest) -> None:
        """A thousand of each case by hand; twenty otherwise."""
        setup, compensator = arrangements(case)[OURS]
        batch = run_many(setup, compensator, el_centro, 1000 if request.config.getoption("--endure") else 20)
        assert batch.unstable == 0
        assert batch.true[batch.worst("J2"), 1] < 0.4
        assert batch.true[batch.worst("J4"), 3] < 1.0

    def test_the_sample_controller_is_told_unstable_where_it_is(self, el_centro: GroundMotion) -> None:
        """Case 4 with a fifth of its damping: the sample controller feeds it, ours does not."""
        setup = set_up(4)
        structure = setup.structure
        free = replace(
            setup, structure=dp.structures.Building(structure.M, 0.2 * structure.C, structure.K, "case 4, undamped")
        )
        with pytest.raises(InputError, match=r"was not run: the loop is unstable: its mode at [\d.]+ Hz grows by"):
            perform_virtual(free, PhaseLeadCompensator(), el_centro)
        run = perform_virtual(free, PhaseLeadCompensator(), el_centro, check=False)
        assert run.at_limit > 0
        assert loop_stability(free, KalmanCompensator.designed(free)).stable


@pytest.mark.prove
def test_the_study_and_its_page(motions: Path, tmp_path: Path) -> None:
    study = vrths_2020.reproduce(motions, tmp_path, plants=1)
    assert {value.verdict for value in study.compared} == {"agrees"}
    assert len(study.compared) == 6 * 9 + 4 * 2 + 4
    assert len(study.criteria) == 4 * 5 * 2
    assert study.page is not None
    text = study.page.read_text("utf-8")
    assert "Kobe" in text
    assert "random plants, case 4" in text
    assert "As measured, with the noise of the sensor." in text
    assert text.count("<svg") == 2  # all numbers beside the replica's, and the first floor
    output = json.loads((tmp_path / "vrths_2020.json").read_text("utf-8"))
    assert len(output["criteria"]) == 40
    assert output["random_plants"]["2"]["unstable"] == 0
    assert study.to_dataframe()["J1"].iloc[0] == pytest.approx(4.64, abs=0.01)


def test_without_the_motions_the_study_says_where_they_are(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DAMPYR_DATA", str(tmp_path))
    with pytest.raises(MissingData, match="get it from"):
        vrths_2020.reproduce()
