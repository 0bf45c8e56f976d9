"""History of specimens: from folders alone, equal names of different rigs apart, equal tests over time."""

import json
from pathlib import Path

import pytest
from tests.records.specimen_record import specimen_record

from dampyr.errors import MissingData
from dampyr.models import Damper
from dampyr.origin import Origin
from dampyr.records import read, specimens, write


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    first = write(specimen_record("SN1", "a", "2026-01-01"), tmp_path / "a.h5")
    write(specimen_record("SN1", "b", "2026-03-01", 0.9), tmp_path / "b.h5")
    write(specimen_record("SN1", "c", "2026-03-02", complete="no"), tmp_path / "c.h5")
    write(specimen_record("SN2", "d", "2026-02-01"), tmp_path / "d.h5")
    write(specimen_record("SN1", "e", "2026-02-01", rig='{"name": "another"}'), tmp_path / "e.h5")
    origin = read(first).origin
    Damper("dahl", {"dahl.kx": 1e3, "dahl.kw": 200.0, "dahl.rho": 1e3}, origin=origin).save(tmp_path / "card.toml")
    verdict = {"verdict": "failed", "origin": Origin("measured", specimens=("SN2",)).as_dict()}
    (tmp_path / "accept.json").write_text(json.dumps(verdict), encoding="utf-8")
    return tmp_path


def test_tests_days_cards_and_verdicts_come_from_the_folder(folder: Path) -> None:
    histories = {(one.specimen, one.laboratory): one for one in specimens(folder)}
    assert list(histories) == [("SN1", "another"), ("SN1", "lab"), ("SN2", "lab")]
    one, other = histories["SN1", "lab"], histories["SN2", "lab"]
    assert (one.complete, one.incomplete) == (2, 1)
    assert one.dates == ("2026-01-01", "2026-03-01", "2026-03-02")
    assert one.operators == ("A. Person",)
    assert (one.cards, one.verdicts) == (("card.toml",), ())
    assert (other.cards, other.verdicts) == ((), ("failed (accept.json)",))
    assert histories["SN1", "another"].cards == ()


def test_equal_tests_are_a_trend_with_closed_forms(folder: Path) -> None:
    (trend,) = next(one for one in specimens(folder) if one.laboratory == "lab" and one.specimen == "SN1").trends
    assert trend.test == "20 mm at 1 Hz, 1 V"
    first, last = trend.points
    assert (first.record, last.record) == ("a", "b")
    assert first.force == pytest.approx(62.83, rel=0.02)  # the mean above 95 % of the peak velocity
    assert first.energy == pytest.approx(1.974, rel=5e-3)
    assert trend.force_change == pytest.approx(-0.1, abs=1e-6)
    assert trend.energy_change == pytest.approx(-0.1, abs=1e-6)


def test_it_shows_itself_as_text_json_figure_and_page(folder: Path) -> None:
    from dampyr.show.pages.result_page import write_page

    result = specimens(folder)
    assert "specimens" in repr(result)
    answer = json.loads(json.dumps(result.as_dict()))
    assert [one["specimen"] for one in answer["specimens"]] == ["SN1", "SN1", "SN2"]
    assert len(result.plot()) == 2
    page = write_page(result, folder / "page.html").read_text("utf-8")
    assert "SN2" in page
    assert "failed (accept.json)" in page


def test_a_folder_without_records_is_refused(tmp_path: Path) -> None:
    with pytest.raises(MissingData, match="no records there"):
        specimens(tmp_path)
