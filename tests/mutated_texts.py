"""Texts of a test with one fault each, and the truth of each: read rightly, refused at its place, or a fault nobody can see.

Five dialects of one table of time, displacement and force; a mutation changes its rows, its header or its bytes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

N = 60
T = 0.01 * np.arange(N)
TABLE = np.column_stack([T, 12.5 * np.sin(7.0 * T + 0.2), 1480.0 * np.cos(7.0 * T + 0.2)])
DIALECTS = {"comma": (",", ".", ""), "semicolon": (";", ",", ""), "tab": ("\t", ".", ""), "blanks": ("   ", ".", ""),
            "quotes": (",", ",", '"')}  # fmt: skip
"""Delimiter, decimal mark and quote."""
NAMES, UNITS = ["time", "displacement", "force"], ["s", "mm", "N"]


@dataclass
class Text:
    """A text that is not yet written: its rows as cells, its header, and what is declared of it."""

    dialect: str
    header: list[list[str]] = field(default_factory=lambda: [[f"{n} [{u}]" for n, u in zip(NAMES, UNITS, strict=True)]])
    rows: list[list[str]] = field(default_factory=list)
    above: str = ""
    options: dict[str, Any] = field(default_factory=dict)
    truth: np.ndarray = field(default_factory=lambda: TABLE.copy())
    """What the file says in s, mm and N, rounded as it is written."""
    refused: str = ""
    """What the refusal says, "" where the text is read."""
    unseen: str = ""
    """Why nobody can see the fault: the truth is then what the file says, and not what was measured."""
    encoding: str = "utf-8"
    ends: tuple[str, ...] = ("\n",)
    tail: str = "\n"

    def __post_init__(self) -> None:
        mark = DIALECTS[self.dialect][1]
        self.truth = np.column_stack([np.round(column, n) for column, n in zip(self.truth.T, (3, 4, 3), strict=True)])
        self.rows = [[f"{t:.3f}", f"{x:.4f}", f"{f:.3f}"] for t, x, f in self.truth]
        self.rows = [[cell.replace(".", mark) for cell in row] for row in self.rows]

    @property
    def first(self) -> int:
        """The line of the first row."""
        return self.above.count("\n") + len(self.header) + 1

    def line(self, cells: list[str], quote: str | None = None) -> str:
        """The cells as the dialect writes them."""
        delimiter, _, usual = DIALECTS[self.dialect]
        quote = usual if quote is None else quote
        return delimiter.join(f"{quote}{cell}{quote}" for cell in cells)

    def content(self) -> bytes:
        """The bytes of the file."""
        lines = [*(self.line(cells) for cells in self.header), *(self.line(row) for row in self.rows)]
        ended = [line + self.ends[k % len(self.ends)] for k, line in enumerate(lines)]
        text = self.above + "".join(ended)
        return (text[: len(text) - len(self.ends[(len(lines) - 1) % len(self.ends)])] + self.tail).encode(self.encoding)


Mutation = Callable[[Text, int], None]
MUTATIONS: dict[str, Mutation] = {}


def mutation(change: Mutation) -> Mutation:
    """A change of a text at the row ``k``, which also sets the truth."""
    MUTATIONS[change.__name__] = change
    return change


@mutation
def cut_in_a_row(text: Text, k: int) -> None:
    text.rows = [*text.rows[:k], text.rows[k][:2]]
    text.tail, text.refused = "", f"line {text.first + k} has 2 values and line {text.first} has 3; repair the line"


@mutation
def cut_after_a_row(text: Text, k: int) -> None:
    text.rows, text.truth, text.tail = text.rows[: k + 1], text.truth[: k + 1], ""
    text.unseen = "the file ends with a whole row"


@mutation
def cut_in_the_last_number(text: Text, k: int) -> None:
    text.rows, text.truth, text.tail = text.rows[: k + 1], text.truth[: k + 1].copy(), ""
    text.rows[k][2] = text.rows[k][2][:-1]
    text.truth[k, 2] = np.sign(text.truth[k, 2]) * np.floor(abs(text.truth[k, 2]) * 100 + 1e-6) / 100
    text.unseen = "what is left of a number is one"


@mutation
def one_mark_is_the_other(text: Text, k: int) -> None:
    mark = DIALECTS[text.dialect][1]
    other = "." if mark == "," else ","
    text.rows[k][1] = text.rows[k][1].replace(mark, other)
    said = "has 4 values" if text.dialect == "comma" else f"'.+' is not a number: the decimal mark is a {NAME_OF[mark]}"
    text.refused = f"line {text.first + k}:? {said}"


NAME_OF = {",": "comma", ".": "point"}


@mutation
def every_mark_is_the_other(text: Text, k: int) -> None:
    if text.dialect == "comma":
        text.refused = (
            "the header names 3 columns and the first line has 6 numbers; decimal commas between commas want quotes"
        )
    mark = DIALECTS[text.dialect][1]
    text.rows = [[cell.replace(mark, "." if mark == "," else ",") for cell in row] for row in text.rows]


@mutation
def line_ends_are_mixed(text: Text, k: int) -> None:
    text.ends = (("\n", "\r\n"), ("\r\r\n", "\n", "\r\n"))[k % 2]


@mutation
def old_line_ends(text: Text, k: int) -> None:
    text.ends, text.tail = (("\r",), ("\r\r\n",))[k % 2], ""


@mutation
def named_columns_in_another_order(text: Text, k: int) -> None:
    order = [[2, 0, 1], [1, 2, 0]][k % 2]
    text.header, text.rows = ([[row[j] for j in order] for row in part] for part in (text.header, text.rows))


@mutation
def unnamed_columns_are_swapped(text: Text, k: int) -> None:
    text.header, text.rows = [], [[row[0], row[2], row[1]] for row in text.rows]
    text.truth = text.truth[:, [0, 2, 1]]
    text.options = {
        "columns": {name: j for j, name in enumerate(NAMES)}, "units": dict(zip(NAMES, UNITS, strict=True)), "header": 0,
    }  # fmt: skip
    text.unseen = "two columns without names are told by nothing"


@mutation
def names_are_swapped(text: Text, k: int) -> None:
    text.header = [["time [s]", "force [mm]", "displacement [N]"]]
    text.refused = "the unit '(mm|N)' does not measure what '(N|m)' measures"


@mutation
def names_are_swapped_with_their_units(text: Text, k: int) -> None:
    text.header = [["time [s]", "force [N]", "displacement [mm]"]]
    text.truth = text.truth[:, [0, 2, 1]]
    text.unseen = "a header that is wrong is as good as one that is right"


@mutation
def a_word_in_a_cell(text: Text, k: int) -> None:
    word = ("ten", "---", "n/a", "overload")[k % 4]
    text.rows[k][1] = word
    text.refused = f"line {text.first + k}: '{word}' is not a number; repair or cut out the line"


@mutation
def a_letter_in_a_number(text: Text, k: int) -> None:
    text.rows[k][2] = f"{text.rows[k][2][:2]}O{text.rows[k][2][2:]}"
    text.refused = f"line {text.first + k}: '.*O.*' is not a number; repair or cut out the line"


@mutation
def an_unknown_name(text: Text, k: int) -> None:
    text.header[0][2] = "pull [N]"
    text.refused = r"no column is the force \(there: time, displacement, pull\); declare which, --column force=NAME"


@mutation
def an_unknown_unit(text: Text, k: int) -> None:
    text.header[0][1] = "displacement [parsnip]"
    text.refused = "unknown unit 'parsnip'; write a unit such as"


@mutation
def an_unknown_word_among_the_units(text: Text, k: int) -> None:
    text.header = [NAMES, ["s", "mm", "parsnip"]]
    text.refused = "unknown unit 'parsnip'; write a unit such as"


@mutation
def units_in_a_row(text: Text, k: int) -> None:
    text.header = [NAMES, [["sec", "mm", "N"], ["s", "(mm)", "[N]"]][k % 2]]


@mutation
def no_unit(text: Text, k: int) -> None:
    text.header[0][2] = "force"
    text.refused = "the column 'force' has no unit; write it in the header, such as"


@mutation
def no_header(text: Text, k: int) -> None:
    text.header = []
    text.refused = "no column is the time, the displacement or the force .there: 3 columns without names, 0 to 2"


@mutation
def an_empty_cell(text: Text, k: int) -> None:
    text.rows[k][1] = ""
    said = "has 2 values" if text.dialect == "blanks" else "the cell of the displacement is empty; repair"
    text.refused = f"line {text.first + k}:? {said}"


@mutation
def one_cell_too_many(text: Text, k: int) -> None:
    text.rows[k] = [*text.rows[k], text.rows[k][2]]
    text.refused = f"line {text.first + k} has 4 values and line {text.first} has 3; repair the line"


@mutation
def a_row_twice(text: Text, k: int) -> None:
    text.rows = [*text.rows[: k + 1], *text.rows[k:]]
    text.refused = f"lines {text.first + k} and {text.first + k + 1} have the same time stamp .*--dt 0.0"


@mutation
def a_row_is_missing(text: Text, k: int) -> None:
    text.rows, text.truth = text.rows[:k] + text.rows[k + 1 :], np.delete(text.truth, k, axis=0)
    # a finding of the record tells the gap


@mutation
def two_rows_are_exchanged(text: Text, k: int) -> None:
    text.rows[k], text.rows[k + 1] = text.rows[k + 1], text.rows[k]
    text.refused = rf"time\[{k + 1}\] = .* s does not come after .* s; time must strictly increase, so sort"


@mutation
def blank_lines_and_comments(text: Text, k: int) -> None:
    text.ends = ("\n", "\n\n", "\n# a remark: 5, 3; 2\n", "\n \n")


@mutation
def a_delimiter_at_the_end(text: Text, k: int) -> None:
    text.ends = (DIALECTS[text.dialect][0] + "\n",)


@mutation
def another_encoding(text: Text, k: int) -> None:
    text.above, text.encoding = "# für den Dämpfer\n", ("utf-16", "latin-1", "utf-8-sig")[k % 3]


@mutation
def lines_of_text_above(text: Text, k: int) -> None:
    text.above = ("Damper no. 3, tested in May\n500 Hz and 2 N preload\n\n", "Date\t3/1/2026 10:00:00\n")[k % 2]


@mutation
def not_a_number(text: Text, k: int) -> None:
    text.rows[k][2] = "nan"
    text.refused = rf"force\[{k}\] = nan N is not finite .*; repair or cut out those samples"


@mutation
def a_second_header(text: Text, k: int) -> None:
    text.rows = [*text.rows[:k], text.header[0], *text.rows[k:]]
    said = "has 6 values" if text.dialect == "blanks" else r"'time \[s\]' is not a number; repair or cut out the line"
    text.refused = f"line {text.first + k}:? {said}"


@mutation
def a_digit_is_another(text: Text, k: int) -> None:
    text.rows[k][2] = text.rows[k][2].replace(text.rows[k][2][-1], "1" if text.rows[k][2][-1] != "1" else "2")
    text.truth[k, 2] = float(text.rows[k][2].replace(",", "."))
    text.unseen = "another digit is a number as good"


@mutation
def thousands_marks(text: Text, k: int) -> None:
    if text.dialect == "comma":
        text.options = {"thousands": ","}
        text.refused = "thousands = ',' was given, but commas part the columns; leave it out"
        return
    decimal = DIALECTS[text.dialect][1]
    mark = "." if decimal == "," else ","
    for row, (_, _, f) in zip(text.rows, text.truth, strict=True):
        row[2] = f"{f:,.3f}".replace(",", "#").replace(".", decimal).replace("#", mark)


def corpus(places: int) -> Iterator[tuple[str, Text]]:
    """Every mutation of every dialect, at so many places."""
    rng = np.random.default_rng(22)
    for name, change in MUTATIONS.items():
        for dialect in DIALECTS:
            for place in range(places):
                text = Text(dialect)
                change(text, int(rng.integers(10, N - 10)) if place else 20)
                yield f"{name}-{dialect}-{place}", text
