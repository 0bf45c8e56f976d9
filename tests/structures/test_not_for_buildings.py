"""Parts without an energy balance say so wherever they are put into a building."""

from pathlib import Path

import numpy as np
import pytest
from tests.identification.synthetic import sine

from dampyr.errors import DampyrWarning
from dampyr.ground_motions import GroundMotion
from dampyr.identification import fit
from dampyr.models import Damper, available_parts
from dampyr.models.part import part
from dampyr.structures import ensemble, respond, two_storey

WORDS = "sigmoid is not for a building: its shift was read off cycles of sine"
SIGMOID = Damper("sigmoid", {"sigmoid.ft": 60.0, "sigmoid.c": 300.0, "sigmoid.vk": 0.02, "sigmoid.vh": 0.005})
MOTION = GroundMotion(np.sin(np.linspace(0.0, 2.0 * np.pi, 101)), 0.02)


def test_the_parts_that_say_so_are_those_whose_page_does() -> None:
    said = {name for name in available_parts() if part(name).not_for_buildings}
    assert said == {name for name in available_parts() if "Do not use it for a building" in part(name).module.__doc__}
    assert said == {"hysteretic_biviscous", "sigmoid", "choi_polynomial", "direction_factor"}


@pytest.mark.prove
def test_a_response_and_an_ensemble_warn() -> None:
    with pytest.warns(DampyrWarning, match=WORDS):
        respond(two_storey(), MOTION, SIGMOID, voltage=0.0)
    with pytest.warns(DampyrWarning, match=WORDS):
        ensemble(two_storey(), MOTION, SIGMOID, voltage=0.0)


@pytest.mark.prove  # its kernels take long to compile
def test_the_fit_says_so() -> None:
    fit_result = fit(sine(SIGMOID, 0.0, noise=1.0), "sigmoid")
    assert any(note.startswith(WORDS) for note in map(str, fit_result.findings))


def test_the_damper_and_its_card_say_so(tmp_path: Path) -> None:
    assert WORDS in repr(SIGMOID)
    card = SIGMOID.save(tmp_path / "card.toml")
    assert f"# {WORDS}" in card.read_text("utf-8")
    assert Damper.load(card).all_laws == SIGMOID.all_laws
