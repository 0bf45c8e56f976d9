"""The page of a validation: what was seen, what was not, and what lies beyond the card."""

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.identification.synthetic import sine
from tests.show.pages.test_html_page import Reader

from dampyr.errors import InputError
from dampyr.identification import Score, score
from dampyr.identification.scoring.validate import Validated
from dampyr.models import Damper, Interpolation
from dampyr.records import Record
from dampyr.show.pages.result_page import write_page
from dampyr.show.pages.validate_page import beyond

CARD = Damper(
    "dahl",
    {"dahl.kx": Interpolation((0.0, 2.0), (800.0, 1800.0)), "dahl.kw": 200.0, "dahl.rho": 3000.0},
    ranges={"displacement": (0.0, 0.006), "velocity": (0.0, 0.05), "frequency": (1.0, 1.5)},
    provenance={"records": "a, b"},
)
RECORDS = [
    sine(CARD, 0.0, "a", 0.005, 1.2, noise=1.0),
    sine(CARD, 1.0, "b", 0.004, 1.3, noise=2.0, seed=1),
    sine(CARD, 1.0, "c", 0.005, 1.1, noise=9.0, seed=2),
]


def scored(records: list[Record], card: Damper = CARD) -> dict[str, Score]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return {r.name: score(card, r, allow_extrapolation=True) for r in records}


def validated(
    scores: dict[str, Score], records: list[Record] = RECORDS, damper: Damper = CARD, card: str = "card"
) -> Validated:
    return Validated(card, damper, tuple(records), scores, {})


def written(card: Damper, records: list[Record], path: Path) -> Reader:
    result = validated(scored(records, card), records, card, "my card.toml")
    html = write_page(result, path / "page.html").read_text("utf-8")
    reader = Reader(html)
    assert reader.open == []
    return reader


@pytest.mark.usefixtures("first_figure_rendered")
def test_a_page_says_which_records_the_card_was_fitted_on(tmp_path: Path) -> None:
    reader = written(CARD, RECORDS, tmp_path)
    assert reader.inside("h1") == ["Validated: my card.toml"]
    assert [text for text in reader.inside("h2") if "record:" in text] == ["The best record: a", "The worst record: c"]
    cells = reader.inside("td")
    assert cells[:2] == ["fitted", "2"]
    assert cells[5:7] == ["unseen", "1"]
    assert "0 V, fitted" in " ".join(reader.inside("text"))
    assert "1 V, unseen" in " ".join(reader.inside("text"))


@pytest.mark.parametrize(
    ("records", "expected"),
    [("a, b", [True, True, False]), ("", [None] * 3), ("120 records", [None] * 3), ("c", [False, False, True])],
)
def test_what_the_card_does_not_say_is_not_known(records: str, expected: list[bool | None]) -> None:
    card = replace(CARD, provenance={"records": records})
    assert list(validated({}, RECORDS, card, "card.toml").fitted_on.values()) == expected


def test_what_lies_outside_is_listed_in_the_units_of_people() -> None:
    assert beyond(CARD, RECORDS[0]) == []
    wide = sine(replace(CARD, ranges={}), 1.0, "wide", 0.009, 0.8)
    by_quantity = {row[0]: row[1:] for row in beyond(CARD, wide)}
    assert list(by_quantity) == ["displacement from the middle", "frequency"]
    assert by_quantity["displacement from the middle"] == [pytest.approx(9.0, rel=0.02), 0.0, 6.0, "mm"]
    assert by_quantity["frequency"] == [pytest.approx(0.8, rel=0.02), 1.0, 1.5, "Hz"]
    beyond_input = beyond(CARD, replace(RECORDS[0], voltage=2.5))
    assert [row[:2] for row in beyond_input] == [["voltage", 2.5]]


@pytest.mark.usefixtures("figures_not_rendered")
def test_an_extrapolated_record_is_shown_without_a_warning(tmp_path: Path) -> None:
    wide = replace(sine(replace(CARD, ranges={}), 1.0, "wide", 0.009, 0.8), voltage=2.5)
    reader = written(CARD, [wide], tmp_path)
    assert "The record: wide" in reader.inside("h2")
    assert "2.5" in reader.inside("td")


def test_the_prediction_is_drawn_with_the_offset_of_its_score(tmp_path: Path) -> None:
    """The synthetic force stands 120 N above the card's: undrawn, the residual would be of that size."""
    from dampyr.show.pages import validate_page

    scores = scored(RECORDS)
    section = validate_page._record(CARD, RECORDS, scores, "The record", "a")
    history = section.blocks[0].figure.axes[3].lines[0]
    assert np.std(history.get_ydata()) < 2.0
    assert abs(np.mean(history.get_ydata())) < 1.0


@pytest.mark.usefixtures("figures_not_rendered")
def test_a_score_that_is_no_number_counts_as_worst(tmp_path: Path) -> None:
    scores = scored(RECORDS)
    scores["a"] = replace(scores["a"], l1=float("nan"), energy=float("inf"))
    reader = Reader(write_page(validated(scores), tmp_path / "p.html").read_text("utf-8"))
    assert "The worst record: a" in reader.inside("h2")


def test_records_without_score_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="c has no score"):
        write_page(validated(scored(RECORDS[:2])), tmp_path / "p.html")
    with pytest.raises(InputError, match="no records to show"):
        write_page(validated({}, []), tmp_path / "p.html")
