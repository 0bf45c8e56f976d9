"""What the records of a fit cannot separate, and the tests that would."""

from dampyr.identification.parameter_uncertainty.identifiability import Identifiability, Inseparable
from dampyr.show.pages.blocks import Text
from dampyr.show.pages.identifiability_section import identifiability_section
from dampyr.show.table import Table


def test_each_is_a_row_of_two_sentences() -> None:
    pair = Inseparable("pair", ("kx", "kw"), "kx and kw go together", "a sine of 2 Hz", "kx, kw")
    [table] = identifiability_section(Identifiability((pair,))).blocks
    assert isinstance(table, Table)
    assert [list(row) for row in table.rows] == [["Kx and kw go together.", "A sine of 2 Hz."]]


def test_records_that_separate_everything_say_so() -> None:
    [text] = identifiability_section(Identifiability(())).blocks
    assert isinstance(text, Text)
    assert "separate every number" in text.text
