"""A corpus of texts with one fault each: every one is read rightly, or refused in a sentence with its place, or nobody sees it.

What nobody sees, and the test says of each why: columns without names that are swapped, names swapped with their units, a
digit that is another, and a file that ends with a whole row or inside its last number.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from dampyr.errors import FileError
from dampyr.records import read
from tests.mutated_texts import DIALECTS, MUTATIONS, Text, corpus

QUICK = list(corpus(1))
FULL = [case for case in corpus(2) if not case[0].endswith("-0")]


def check(folder: Path, name: str, text: Text) -> None:
    path = folder / f"{name}.csv"
    path.write_bytes(text.content())
    if text.refused:
        with pytest.raises(FileError, match=text.refused) as caught:
            read(path, **text.options)
        assert str(caught.value).startswith(f"{path}: ")
        assert "\n" not in str(caught.value)
        return
    record = read(path, **text.options)
    found = np.column_stack([record.time, 1e3 * record.displacement, record.force])
    np.testing.assert_allclose(found, text.truth, rtol=1e-12, atol=1e-12)


def test_the_corpus_has_three_hundred_files_and_says_what_nobody_sees() -> None:
    assert len(QUICK) + len(FULL) == 2 * len(MUTATIONS) * len(DIALECTS) >= 300
    unseen = {name.split("-")[0] for name, text in QUICK if text.unseen}
    assert unseen == {
        "cut_after_a_row", "cut_in_the_last_number", "unnamed_columns_are_swapped", "names_are_swapped_with_their_units",
        "a_digit_is_another",
    }  # fmt: skip


@pytest.mark.parametrize(("name", "text"), QUICK, ids=[name for name, _ in QUICK])
def test_a_mutated_text(tmp_path: Path, name: str, text: Text) -> None:
    check(tmp_path, name, text)


@pytest.mark.prove
@pytest.mark.parametrize(("name", "text"), FULL, ids=[name for name, _ in FULL])
def test_a_mutated_text_elsewhere(tmp_path: Path, name: str, text: Text) -> None:
    check(tmp_path, name, text)
