"""A part of the study as a table: published numbers as they are printed, ours in as many digits as are asked for."""

from tests.studies.raminelli_2020.small_study import study

from dampyr.studies._compared_value import PrintedNumber, unchecked
from dampyr.studies._study_run import compared_table


def test_published_numbers_keep_their_printed_digits() -> None:
    table = compared_table(study().compared, "a caption", digits=3)
    assert (table.caption, table.digits) == ("a caption", 3)
    assert [row[2] for row in table.rows] == ["2.000", "3.0", "5", "−1.50"]
    assert [row[3] for row in table.rows[:3]] == [2.0, 3.3, 5.0]
    assert table.rows[3][3] is None
    assert [row[5].kind for row in table.rows] == ["agrees", "differs", "agrees", "cannot be checked"]


def test_powers_of_ten_keep_as_many_digits_as_are_printed() -> None:
    [row] = compared_table([unchecked("a", "b", PrintedNumber("1.234e-05"), "", "nothing")]).rows
    assert row[2] == "1.234·10⁻⁵"
