"""The figures of a page as vector files of their own."""

from pathlib import Path

import pytest
from tests.show.pages.test_html_page import full_page

from dampyr.show.figures.ground_motion import ground_motion
from dampyr.show.pages import saved_figures
from dampyr.show.pages.saved_figures import figure_files, keep


@pytest.mark.prove
def test_figures_of_a_page_are_left_as_vector_files_where_they_are_asked_for(tmp_path: Path) -> None:
    with figure_files(tmp_path / "drawn"):
        full_page.__wrapped__()
    full_page.__wrapped__()
    names = [f"{number}-loops.{kind}" for number in ("01", "02") for kind in ("csv", "pdf", "svg")]
    drawn_files = {path.name: path.read_bytes() for path in (tmp_path / "drawn").iterdir()}
    assert sorted(drawn_files) == names
    assert drawn_files["01-loops.pdf"].startswith(b"%PDF")
    assert b"displacement [mm]" in drawn_files["02-loops.svg"]
    assert b"var(--" not in drawn_files["02-loops.svg"]
    with figure_files(tmp_path / "again"):
        full_page.__wrapped__()
    assert {path.name: path.read_bytes() for path in (tmp_path / "again").iterdir()} == drawn_files


def test_a_figure_is_kept_within_and_nowhere_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written: list[Path] = []
    monkeypatch.setattr(saved_figures, "save", lambda figure, path, **journal: written.append(path))
    figure = ground_motion([0.0, 1.0], [0.0, 1.0])
    with figure_files(tmp_path / "outer"):
        with figure_files(tmp_path / "inner"):
            keep(figure, 3, "over-time")
        keep(figure, 12, "peaks")
    keep(figure, 4, "peaks")
    assert [path.relative_to(tmp_path).as_posix() for path in written] == [
        f"{name}.{kind}" for name in ("inner/03-over-time", "outer/12-peaks") for kind in ("svg", "pdf", "csv")
    ]  # fmt: skip
