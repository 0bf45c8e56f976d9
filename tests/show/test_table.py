"""A table: its heads, and what it refuses."""

import pytest

from dampyr.errors import InputError
from dampyr.show.table import Table, Verdict


def test_heads_hold_the_units_where_there_are_any() -> None:
    assert Table(("input", "note"), [[1.98, "x"]], ("V", "")).heads == ["input [V]", "note"]
    assert Table(("input",), []).heads == ["input"]


@pytest.mark.parametrize("name", ["units", "align"])
def test_a_column_has_one_unit_and_one_side(name: str) -> None:
    with pytest.raises(InputError, match=f"a table of 2 columns has 1 {name}"):
        Table(("a", "b"), [], **{name: ("left",)})


def test_the_first_row_of_another_length_is_named() -> None:
    with pytest.raises(InputError, match="row 2 of a table has 3 cells; its columns are 2"):
        Table(("a", "b"), [[1, 2], [1, 2, 3], [1]])


def test_a_verdict_is_of_a_known_kind() -> None:
    assert Verdict("passed", "all of it").text == "all of it"
    with pytest.raises(InputError, match="verdict 'good' is not known; choose from agrees"):
        Verdict("good")  # type: ignore[arg-type]
