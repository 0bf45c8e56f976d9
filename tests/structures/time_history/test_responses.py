"""One input gives a response, a list of them responses side by side."""

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion, el_centro
from dampyr.models import Damper
from dampyr.structures import Response, control_law, respond, two_storey
from dampyr.structures.time_history.responses import Responses

MOTION = GroundMotion(el_centro().acceleration[:200], el_centro().dt, "two seconds")


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


def test_a_case_is_taken_by_its_name(cubics: Damper) -> None:
    responses = respond(two_storey(), el_centro(), cubics, voltage=[1.98])
    assert list(responses) == ["no damper", "1.98 V"]
    assert responses["1.98 V"] is responses.cases["1.98 V"]
    with pytest.raises(InputError, match=r"'9 V' is not a case; choose from 'no damper', '1\.98 V'"):
        responses["9 V"]
