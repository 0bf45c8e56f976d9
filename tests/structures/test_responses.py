"""One input gives a response, a list of them responses side by side."""

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion, el_centro
from dampyr.models import Damper
from dampyr.structures import RespondOptions, Response, control_law, ensemble, respond, two_storey
from dampyr.structures.control_laws import law_of
from dampyr.structures.time_history.responses import Responses

MOTION = GroundMotion(el_centro().acceleration[:200], el_centro().dt, "two seconds")
DAHL = {"dahl.kx": 1000.0, "dahl.kw": 200.0, "dahl.rho": 1000.0}


def test_a_list_gives_a_case_for_each_input_after_the_bare_building(cubics: Damper) -> None:
    stages: list[tuple[str, float]] = []
    law = control_law("on_off", high=2.0)
    responses = respond(
        two_storey(), MOTION, {1: cubics}, [0.0, "1.5 V", law], progress=lambda *now: stages.append(now)
    )
    assert isinstance(responses, Responses)
    assert list(responses.cases) == ["no damper", "0 V", "1.5 V", "on_off 0 to 2 V"]
    assert (responses.unit, responses.draws) == ("V", 0)
    for name, voltage in (("1.5 V", 1.5), ("on_off 0 to 2 V", law)):
        alone = respond(two_storey(), MOTION, {1: cubics}, voltage)
        assert isinstance(alone, Response)
        np.testing.assert_array_equal(responses.cases[name].displacement, alone.displacement)
    np.testing.assert_array_equal(responses.cases["no damper"].force, respond(two_storey(), MOTION).force)
    assert [stage for stage, _ in stages] == ["without damper", "case 2 of 4", "case 3 of 4", "case 4 of 4"]
    assert [done for _, done in stages] == [0.0, 0.25, 0.5, 0.75]


def test_the_case_names_the_inputs_of_several_dampers(cubics: Damper) -> None:
    dampers = {1: cubics, 2: cubics}
    responses = respond(two_storey(), MOTION, dampers, voltage=(1.0, {1: 0.0, 2: 2.0}, 1.0))
    assert list(responses.cases) == ["no damper", "1 V", "storey 1: 0 V; storey 2: 2 V"]
    assert list(respond(two_storey(), MOTION, voltage=[]).cases) == ["no damper"]


def test_what_is_changed_of_a_damper_is_an_option(cubics: Damper) -> None:
    options = RespondOptions(brace=2e5, after=1.0)
    braced = respond(two_storey(), MOTION, cubics, 1.0, options=options)
    np.testing.assert_array_equal(
        braced.displacement, respond(two_storey(), MOTION, cubics.on_brace(2e5), 1.0, after=1.0).displacement
    )
    late = Damper("dahl + delay", DAHL | {"delay.tau": 0.02})
    at_once = respond(two_storey(), MOTION, late, without=["delay"])
    np.testing.assert_array_equal(
        at_once.displacement, respond(two_storey(), MOTION, late.without("delay")).displacement
    )
    peaks = ensemble(two_storey(), MOTION, [None, late], without="delay", quantities="drift").dataset
    plain = ensemble(two_storey(), MOTION, [None, late.without("delay")], quantities="drift").dataset
    np.testing.assert_array_equal(peaks.drift, plain.drift)


def test_draws_are_of_the_dampers_before_their_parts_are_left_out() -> None:
    """As `Damper.draws` gives them, by the seed; of several dampers each has its own seed, of one in two places one."""
    card = Damper("dahl", DAHL, covariance=np.diag([1e2, 1.0, 1e2]))
    drawn = card.draws(20, 3)
    responses = respond(two_storey(), MOTION, {1: card}, voltage=[0.0], draws=20, seed=3)
    peaks = ensemble(two_storey(), MOTION, drawn, 0.0, accuracy="strict", quantities="force").dataset.force.values
    low, high = responses.intervals["0 V"]["peak_force_N"]
    np.testing.assert_array_equal([low, high], np.quantile(peaks[0, :, 0, 0, 0], (0.05, 0.95), axis=0))
    both = ensemble(two_storey(), MOTION, [None, {1: card, 2: card}], 0.0, draws=2, seed=3, quantities="force").dataset
    ours = ensemble(
        two_storey(), MOTION, [None, *({1: d, 2: d} for d in card.draws(2, 3))], 0.0, quantities="force"
    ).dataset
    np.testing.assert_array_equal(both.force, ours.force)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"voltage": []}, "no input and no control law is given"),
        ({"voltage": [1.0], "current": [1.0]}, "both voltage= and current="),
        ({"voltage": 1.0, "draws": 20}, r"write it as a list, such as voltage=\[1.98\]"),
        ({"voltage": [{1: 1.0}], "draws": 20}, "the same input for all dampers"),
        ({"voltage": [1.0], "draws": 20, "step": 0.001}, "draws and step exclude each other"),
        ({"voltage": [1.0, 9.0]}, "9 V is outside the calibrated range"),
        ({"voltage": np.array([0.0, 1.0])}, "several, to compare them, in a list"),
        ({"current": [1.0]}, "takes a voltage"),
        ({"voltage": 1.0, "without": "spring"}, "'spring' is not a part of dahl"),
        ({"voltage": 1.0, "braces": 1e5}, "did you mean 'brace'"),
    ],
)
def test_what_is_wrong_is_said_before_anything_is_computed(given: dict, words: str, cubics: Damper) -> None:
    done: list[object] = []
    with pytest.raises(InputError, match=words):
        respond(two_storey(), MOTION, cubics, **given, progress=lambda *now: done.append(now))
    assert not done


def test_draws_need_dampers() -> None:
    with pytest.raises(InputError, match="draws = 20 are of dampers, and none are given"):
        respond(two_storey(), MOTION, voltage=[], draws=20)


def test_limits_of_an_ensemble_are_texts_with_units(cubics: Damper) -> None:
    given = (two_storey(), [MOTION, MOTION.scaled(-0.5)], [None, cubics], [1.0], [0.5, 1.0, 2.0])
    result = ensemble(*given, limits=("5 mm", "1%", "0.5g", "force=1kN"), height=3.0, intensity="scale")
    assert [(c.quantity, c.limit_unit, c.intensity) for c in result.curves] == [
        ("drift", "m", "scale"), ("drift", "", "scale"), ("acceleration", "m/s^2", "scale"), ("force", "N", "scale"),
    ]  # fmt: skip
    assert result.curves[3].limit == 1000.0
    again = ensemble(*given).evaluated("5 mm", intensity="scale")
    assert [c.theta for c in again.curves[0].curves] == [c.theta for c in result.curves[0].curves]
    assert result.to_xarray() is result.dataset
    for wrong, words in (
        ({"limits": "5"}, "'5' has no unit of a drift or an acceleration"),
        ({"limits": "1%"}, "give height too"),
        ({"limits": "5mm", "height": 3.0}, "height belongs to a limit in per cent"),
        ({"limits": "colour=5mm"}, "'colour' is not known"),
        ({"limits": "force=5mm"}, "has no unit of a force; write it as in force=1N"),
        ({"limits": "force=5%"}, "which only a drift has"),
        ({"limits": "-5mm"}, "must be greater than 0"),
        ({"limits": "5mm", "quantities": "force"}, "a limit of drift, which is not among the quantities"),
        ({"quantities": ()}, "quantities is empty"),
    ):
        with pytest.raises(InputError, match=words):
            ensemble(*given, **wrong)


def test_a_case_is_taken_by_its_name(cubics: Damper) -> None:
    responses = respond(two_storey(), el_centro(), cubics, voltage=[1.98])
    assert list(responses) == ["no damper", "1.98 V"]
    assert responses["1.98 V"] is responses.cases["1.98 V"]
    with pytest.raises(InputError, match=r"'9 V' is not a case; choose from 'no damper', '1\.98 V'"):
        responses["9 V"]


def test_a_law_is_a_text_over_the_range_of_its_damper(cubics: Damper) -> None:
    assert law_of("on_off:lag=10ms", cubics) == control_law(
        "on_off", low=cubics.range[0], high=cubics.range[1], lag=0.01
    )
