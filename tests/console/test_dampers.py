"""Dampers that can be chosen on a page: cards first, then published sets; no other file."""

import pytest

pytest.importorskip("fastapi")

from dampyr import studies
from dampyr.console.dampers import MAX_CARD, damper_of, dampers, title_of
from dampyr.errors import InputError, MissingData
from dampyr.models import Damper, Interpolation

CARD = Damper("dahl", {"dahl.kx": Interpolation((0.5, 2.0), (900.0, 1800.0)), "dahl.kw": 150.0, "dahl.rho": 3000.0})


@pytest.fixture
def cards(data):
    """A data folder with a card and a file that is none."""
    (data / "cards").mkdir()
    CARD.save(data / "cards" / "mine.toml")
    (data / "cards" / "broken.toml").write_text("[nothing")
    return data


def test_cards_come_first_and_what_cannot_be_read_is_left_out(cards):
    links = dampers(cards)
    assert [link.name for link in links] == ["cards/mine.toml", *studies.available_dampers()]
    mine = links[0]
    assert (mine.title.partition(" (")[0], mine.unit, mine.low, mine.high) == ("mine", "V", 0.5, 2.0)
    assert all(link.title.startswith(f"published: {link.name}") for link in links[1:])
    assert title_of("cards/mine.toml") == "mine.toml"


def test_a_damper_is_that_of_its_card_or_its_publication(cards):
    assert damper_of(cards, "cards/mine.toml").all_laws == CARD.all_laws
    assert damper_of(cards, "raminelli_2020").all_laws == studies.raminelli_2020.damper().all_laws


def test_no_other_file_is_a_damper(cards, monkeypatch):
    monkeypatch.chdir(cards / "cards")
    with pytest.raises(
        InputError, match=r"'mine\.toml' is neither a card nor a published damper; choose from cards/broken"
    ):
        damper_of(cards, "mine.toml")
    with pytest.raises(MissingData, match="no such file"):
        damper_of(cards, "cards/none.toml")
    with pytest.raises(InputError, match="not a valid file name"):
        damper_of(cards, "cards/../../secret.toml")
    (cards / "cards" / "large.toml").write_text("#" * (MAX_CARD + 1024))
    with pytest.raises(InputError, match="has 1025 KiB, a card has at most 1024"):
        damper_of(cards, "cards/large.toml")


def test_a_card_without_an_input_has_no_unit(cards):
    Damper("dahl", {"kx": 900.0, "kw": 150.0, "rho": 3000.0}, input="none").save(cards / "cards" / "friction.toml")
    link = next(link for link in dampers(cards) if link.name == "cards/friction.toml")
    assert (link.unit, link.low, link.high) == ("", 0.0, 0.0)
