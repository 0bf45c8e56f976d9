"""Building blocks of a page, and what they show by themselves."""

from dampyr.findings import Finding
from dampyr.show.descriptions import description_of
from dampyr.show.figures.ground_motion import ground_motion
from dampyr.show.pages.blocks import FigureBlock, Section, Text, to_look_at
from dampyr.show.table import Table, Verdict


def test_an_empty_line_parts_paragraphs() -> None:
    assert Text("One.\nStill one.\n\n\n\n Two. \n\n").paragraphs == ["One.\nStill one.", "Two."]
    assert repr(Text("One.\n\nTwo.")).splitlines()[0] == "<Text of 2 paragraphs>"


def test_findings_are_a_paragraph_each_and_nothing_where_there_are_none() -> None:
    assert to_look_at([]) == []
    findings = [Finding("doubt", "the scale stood askew"), Finding("note", "it is old")]
    [text] = to_look_at(findings)
    assert isinstance(text, Text)
    assert text.paragraphs == ["Before you use the numbers:", *(finding.sentence for finding in findings)]


def test_a_section_shows_the_first_words_of_its_blocks() -> None:
    figure = FigureBlock(ground_motion([0.0, 1.0], [0.0, 1.0]), "A motion.")
    section = Section("All", [Text("Words."), Table(("a",), [[1]], caption="Ones."), figure, Verdict("passed")])
    assert description_of(section).rows == [
        ("Text", "Words."), ("Table", "Ones."), ("FigureBlock", "A motion."), ("Verdict", "passed"),
    ]  # fmt: skip
    assert description_of(section.blocks[1]).rows == [("columns", "a"), ("rows", "1"), ("caption", "Ones.")]
    width, height = figure.figure.get_size_inches()
    assert description_of(figure).title == f"FigureBlock, {width:.3g} × {height:.3g} in"
    assert not hasattr(figure, "plot")  # its figure is drawn already
