"""The job that validates a card, in this process: the scores are those of the library, and its page is written."""

import json

import pytest

pytest.importorskip("fastapi")

from tests.identification.synthetic import sine

from dampyr import identification, records
from dampyr.console.identify_schemas import ValidateRequest
from dampyr.console.jobs import CURVES, DATA, PAGE, validate
from dampyr.console.safe_paths import OWN
from dampyr.errors import InputError
from dampyr.models import Constant, Damper

CARD = Damper("dahl", {"dahl.kx": Constant(900.0, 0.0, 2.0), "dahl.kw": 150.0, "dahl.rho": 3000.0})


@pytest.fixture
def folder(data):
    """The folder of a job, in data with a card and a test of a damper that is 10 % stronger."""
    (data / "cards").mkdir()
    CARD.save(data / "cards" / "mine.toml")
    good = sine(CARD, 1.0, "strong", offset=0.0)
    records.write(good.replace(note="stronger", force=1.1 * good.force), data / "strong.h5")
    place = data / OWN / "jobs" / "0123456789abcdef"
    place.mkdir(parents=True)
    return place


def validated(folder, **request):
    return validate.run(ValidateRequest(**request).model_dump(), folder, lambda stage, done: None)


def test_a_force_that_is_a_tenth_too_strong_is_missed_by_an_eleventh(data, folder):
    result = validated(folder, records=["data/strong.h5"], card="cards/mine.toml")
    (score,) = result[DATA]["scores"].values()
    expected = identification.validate(CARD, [records.read(data / "strong.h5")])
    assert score["l1"] == pytest.approx(expected.scores["strong"].l1, rel=1e-9)
    assert score["l1"] == pytest.approx(0.1 / 1.1, rel=0.02)  # of the measured force
    assert result["card"] == "mine.toml"
    assert result["verdict"][0] == f"Mean L1 {100 * score['l1']:.2f} % over 1 record."
    assert result["tables"][0]["rows"][0][0] == "strong"
    lines = json.loads((folder / CURVES).read_text("utf-8"))["strong"]
    both = lines["time"]
    assert max(both["measured"]["y"]) == pytest.approx(1.1 * max(both["model"]["y"]), rel=0.01)
    assert both["measured"]["x"][0] == both["model"]["x"][0] > 1.9, "only what is scored"
    page = (folder / PAGE).read_text("utf-8")
    assert "mine" in page
    assert "strong" in page


def test_a_card_that_is_none_is_a_sentence(folder):
    with pytest.raises(InputError, match="neither a card nor a published damper"):
        validated(folder, records=["data/strong.h5"], card="nobody_1900")
