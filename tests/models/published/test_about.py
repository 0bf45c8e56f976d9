"""Sets of published numbers as their files have them."""

from __future__ import annotations

from pathlib import Path

import pytest

from dampyr.errors import InputError
from dampyr.models import published
from dampyr.models.published._about import read_sets


def test_an_unknown_set_lists_the_others() -> None:
    with pytest.raises(
        InputError, match=r"'spencer_97' is not among the published sets; did you mean 'spencer_1997'\?"
    ):
        published.damper("spencer_97")
    with pytest.raises(InputError, match=r"choose from .*azimi_2020"):
        published.about("_about")


def test_a_file_is_a_set(tmp_path: Path) -> None:
    folder = Path(published.__file__).parent
    (tmp_path / "another_2026.toml").write_bytes((folder / "azimi_2020.toml").read_bytes())
    assert read_sets(tmp_path / "another_2026.toml") == {"another_2026": published.about("azimi_2020")}
    assert set(read_sets(folder / "eldorado.toml")) == {"eldorado_as_noted", "eldorado_as_run"}
