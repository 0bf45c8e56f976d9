"""Cards: they come back to the last bit, and broken ones are refused by name."""

from pathlib import Path

import numpy as np
import pytest
from tests.models.dahl_of_chapter_4 import published

from dampyr.errors import FileError, MissingData
from dampyr.models import Damper


def test_a_card_comes_back_to_the_last_bit(tmp_path: Path) -> None:
    damper = published(
        covariance=np.diag(np.linspace(0.1, 1.2, 12)) / 3.0,
        ranges={"displacement": (0.0, 0.0194), "velocity": (0.0, 0.076)},
        bandwidth=12.5,
        provenance={"records": "ensaio1.1, ensaio2.1"},
    )
    again = Damper.load(damper.save(tmp_path / "card.toml"))
    assert again.all_laws == damper.all_laws
    assert again.ranges == damper.ranges
    assert (again.bandwidth, again.input, again.provenance) == (12.5, "V", damper.provenance)
    np.testing.assert_array_equal(again.covariance, damper.covariance)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("schema = 1", "schema = 2", "schema 2 is not supported"),
        ('unit = "N s/m"', 'unit = "N s/mm"', "a card holds 'N s/m'"),
        ('kind = "polynomial"', 'kind = "magic"', "unknown law"),
        ("schema = 1", "schema = ", "not a TOML file"),
        ('input = "V"', 'input = "W"', "'V', 'A' or 'none'"),
        ("42745.0", "-42745.0", "greater than 0"),
        ("[damper]", "[dumper]", "lacks 'damper'"),
        ("[damper]", "[covariance]\nwithin_records_only = 3\n[damper]", "= 3 is not allowed; give a list of names"),
    ],
)
def test_a_broken_card_is_refused_by_name(tmp_path: Path, old: str, new: str, words: str) -> None:
    path = published().save(tmp_path / "card.toml")
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(FileError, match=words) as caught:
        Damper.load(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value).replace("\n", "", 0) or "TOML" in str(caught.value)


def test_a_missing_card_says_how_to_make_one(tmp_path: Path) -> None:
    with pytest.raises(MissingData, match="dampyr identify"):
        Damper.load(tmp_path / "none.toml")
