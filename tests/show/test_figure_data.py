"""What a figure draws, as a table: against the arrays that it was made of."""

import csv
from pathlib import Path

import numpy as np
from tests.show.figures.figure_examples import MAKERS, T, V, X

from dampyr import show
from dampyr.origin import SIMULATED
from dampyr.show.figures.band import band
from dampyr.show.figures.building import building_response


def columns_of(path: Path, delimiter: str = ",") -> dict[str, list[str]]:
    with path.open(encoding="utf-8") as file:
        head, *rows = csv.reader(file, delimiter=delimiter)
    return {name: [row[k] for row in rows if row[k]] for k, name in enumerate(head)}


def test_lines_are_pairs_of_columns_in_the_units_of_the_axes(tmp_path: Path) -> None:
    figure = building_response(T, {"no damper": X, "0 V": 0.5 * X})
    found = columns_of(show.save(figure, tmp_path / "figure.csv"))
    assert "0 V: 6 mm: displacement [mm]" in found
    np.testing.assert_allclose(
        [float(x) for x in found["0 V: 6 mm: displacement [mm]"]], 500.0 * X, rtol=1e-7, atol=1e-9
    )
    np.testing.assert_allclose([float(x) for x in found["0 V: 6 mm: time [s]"]], T, rtol=1e-7)


def test_a_band_has_its_edges(tmp_path: Path) -> None:
    found = columns_of(show.save(band(T, V, V - 1.0, V + T), tmp_path / "band.csv"))
    np.testing.assert_allclose([float(x) for x in found["90 % band: force [N], low"]], V - 1.0, rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose([float(x) for x in found["90 % band: force [N], high"]], V + T, rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose([float(x) for x in found["90 % band: time [s]"]], T)


def test_error_bars_and_bars_have_both_ends_and_panels_a_number(tmp_path: Path) -> None:
    found = columns_of(show.save(MAKERS["laws"](), tmp_path / "laws.csv"))
    assert found["panel 1, fitted: voltage [V]"] == ["0", "2"]
    assert found["panel 1, fitted: k_w [N]"] == ["10", "190"]
    assert (found["panel 1, k_w [N], from"], found["panel 1, k_w [N], to"]) == (["5"], ["15"])  # the other is infinite
    assert found["panel 2, published: ρ [1/mm]"] == ["42.7448"]
    found = columns_of(show.save(MAKERS["scores"](), tmp_path / "scores.csv"))
    assert found["bars: L1 ratio [%], to"] == ["7.5", "12"]


def test_with_decimal_commas_semicolons_part_the_columns(tmp_path: Path) -> None:
    found = columns_of(show.save(MAKERS["laws"](), tmp_path / "laws.csv", decimal_comma=True), ";")
    assert found["panel 2, published: ρ [1/mm]"] == ["42,7448"]


def test_the_first_line_says_what_was_not_measured(tmp_path: Path) -> None:
    figure = building_response(T, {"no damper": X})
    SIMULATED.stamp(figure)
    first, head, *_ = show.save(figure, tmp_path / "figure.csv").read_text(encoding="utf-8").splitlines()
    assert first == "# SIMULATED"
    assert head.startswith("no damper")
