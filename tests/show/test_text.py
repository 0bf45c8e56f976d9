"""The text of a result: rows below one another, long ones cut, many counted."""

from dampyr.show.text import MAX_LETTERS, MAX_LINES, rows_as_text


def test_values_stand_below_one_another() -> None:
    assert rows_as_text("Title", [("a", "1"), ("longer", "2 N")]) == "<Title>\n  a       1\n  longer  2 N"
    assert rows_as_text("Title", []) == "<Title>"


def test_of_too_many_rows_the_rest_is_counted() -> None:
    rows = [(f"row {k}", str(k)) for k in range(MAX_LINES + 5)]
    lines = rows_as_text("Title", rows).splitlines()[1:]
    assert len(lines) == MAX_LINES
    assert [line.split()[-1] for line in lines[:-1]] == [str(k) for k in range(MAX_LINES - 1)]
    assert lines[-1].strip() == "and 6 more"
    assert len(rows_as_text("Title", rows[:MAX_LINES]).splitlines()) == 1 + MAX_LINES


def test_a_long_value_is_one_line_that_ends_with_dots() -> None:
    value = "word\n" * 40
    line = rows_as_text("Title", [("a", value)]).splitlines()[1].removeprefix("  a  ")
    assert line.endswith(" …")
    assert len(line) <= MAX_LETTERS
    assert value.replace("\n", " ").startswith(line.removesuffix(" …"))
    exact = "x" * MAX_LETTERS
    assert rows_as_text("Title", [("a", exact)]).endswith(exact)
