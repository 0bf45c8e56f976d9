# The sheet of a shock dyno: its rows are met exactly; Dixon, The Shock Absorber Handbook (2007), the characteristic.
"""The force table: its rows, what is between and beyond, sheets that are refused, and what a fit finds."""

from pathlib import Path

import numpy as np
import pytest
from tests.models.parts.found_again import damper, six_sines

from dampyr.errors import DampyrWarning, InputError
from dampyr.identification import fit
from dampyr.models import Damper
from dampyr.models.parts import force_table

SPEEDS = [0.052, 0.131, 0.262, 0.393, 0.524, 1.048]
REBOUND = [250.0, 480.0, 700.0, 860.0, 1010.0, 1600.0]
BUMP = [120.0, 210.0, 300.0, 350.0, 400.0, 640.0]


def along(table: force_table.ForceTable, v: np.ndarray) -> np.ndarray:
    return Damper([table]).force(np.arange(len(v)) * 1.0, np.zeros(len(v)), voltage=0.0, velocity=v)


@pytest.mark.usefixtures("plain")
def test_it_meets_each_row_and_is_straight_between_and_beyond() -> None:
    table = force_table.from_rows(SPEEDS, REBOUND, BUMP)
    v = np.concatenate([-np.linspace(1.048, 0.0, 40), np.linspace(0.0, 1.048, 40), SPEEDS, [2.096, -2.096]])
    out, back = (np.interp(np.abs(v), [0.0, *SPEEDS], [0.0, *row]) for row in (REBOUND, BUMP))
    expected = np.where(v >= 0.0, out, -back)
    expected[-2:] = 1600.0 + 2 * 590.0, -(640.0 + 2 * 240.0)
    np.testing.assert_allclose(along(table, v), expected, atol=1e-9)


@pytest.mark.prove
def test_it_only_dissipates_and_never_falls() -> None:
    v = np.linspace(-2.0, 2.0, 4_001)
    force = along(force_table.from_rows(SPEEDS, REBOUND, BUMP), v)
    assert np.min(force * v) >= 0.0
    assert np.min(np.diff(force)) >= 0.0


@pytest.mark.usefixtures("plain")
def test_a_sheet_is_read_with_its_units_in_any_order(tmp_path: Path) -> None:
    rows = zip(SPEEDS, REBOUND, BUMP, strict=True)
    sheet = tmp_path / "dyno.csv"
    sheet.write_text(
        "Compression force [kN];Velocity [mm/s];Rebound force [kN]\n"
        + "\n".join(f"{-c / 1e3:.3f};{1e3 * s:.1f};{e / 1e3:.3f}".replace(".", ",") for s, e, c in rows)
    )
    expected = force_table.from_rows(SPEEDS, REBOUND, BUMP)
    got = force_table.from_sheet(sheet)
    for key in expected.__dataclass_fields__:
        assert getattr(got, key) == pytest.approx(getattr(expected, key)), key
    sheet.write_text("speed (in/s), rebound (lbf), bump (lbf)\n2, 50, 20\n10, 100, 40\n")
    v = 0.0254 * np.array([0.0, 1.0, 2.0, 6.0, 10.0, 14.0, -10.0, 50.0])
    pounds = [0.0, 25.0, 50.0, 75.0, 100.0, 125.0, -40.0, 350.0]
    np.testing.assert_allclose(along(force_table.from_sheet(sheet), v), 4.4482216152605 * np.array(pounds), atol=1e-9)


@pytest.mark.usefixtures("plain")
def test_a_sheet_of_another_laboratory_is_read_as_records_are(tmp_path: Path) -> None:
    """Units below the names, thousands, another encoding, names that nobody knows, counts."""
    sheet = tmp_path / "dyno.txt"
    sheet.write_bytes(
        "Geschwindigkeit\tZugstufe\tDruckstufe\nmm/s\tN\tN\n100\t1.250,5\t400,0\n200\t2.000,0\t500,0\n".encode("cp1252")
    )
    v = np.array([0.1, 0.2, -0.1, -0.2])
    np.testing.assert_allclose(along(force_table.from_sheet(sheet, thousands="."), v), [1250.5, 2000.0, -400.0, -500.0])
    sheet.write_text("rpm Zug Druck\n10 100 40\n20 150 50\n")
    columns, units = (
        {"speed": "rpm", "extension": "Zug", "compression": "Druck"},
        {"extension": "lbf", "compression": "lbf"},
    )
    table = force_table.from_sheet(sheet, columns=columns, units=units, factors={"speed": "5 mm/s"})
    np.testing.assert_allclose(along(table, 0.5 * v), 4.4482216152605 * np.array([100.0, 150.0, -40.0, -50.0]))


@pytest.mark.usefixtures("plain")
def test_a_sheet_of_one_row_is_a_dashpot_in_each_direction() -> None:
    v = np.array([-0.3, 0.0, 0.05, 0.1, 0.4])
    np.testing.assert_allclose(along(force_table.from_rows([0.1], [50.0], [20.0]), v), [-60.0, 0.0, 25.0, 50.0, 200.0])


@pytest.mark.usefixtures("plain")
def test_of_more_rows_than_six_those_are_kept_that_matter_and_the_error_is_told() -> None:
    s = np.linspace(0.05, 1.0, 20)
    straight = 100.0 * s + 40.0 * np.minimum(s / 0.2, 1.0)
    table = force_table.from_rows(s, straight, straight)
    np.testing.assert_allclose(along(table, s), straight, atol=1e-9)  # one kink: no row is lost, and nothing to warn of
    with pytest.warns(
        DampyrWarning, match=r"a table has 6 rows and the sheet 20: at [\d.]+ m/s it is ([\d.]+) N off"
    ) as told:
        table = force_table.from_rows(s, 1e3 * np.sqrt(s), 1e3 * np.sqrt(s))
    off = np.abs(along(table, s) - 1e3 * np.sqrt(s)).max()
    assert f"{off:.3g} N off" in str(told[0].message)
    assert off < 15.0


@pytest.mark.parametrize(
    ("rows", "reason"),
    [
        (([0.1, 0.1], [1.0, 2.0], [1.0, 2.0]), "do not rise"),
        (([-0.1, 0.1], [1.0, 2.0], [1.0, 2.0]), "do not rise"),
        (([0.0, 0.1], [9.0, 20.0], [3.0, 20.0]), "take gas force and friction off"),
        (([0.1, 0.2], [5.0, 4.0], [1.0, 2.0]), "in extension the force falls from 5 N at 0.1 m/s to 4 N"),
        (([0.1, 0.2], [5.0, 6.0], [1.0]), "a speed and two forces"),
        (([0.1, np.nan], [5.0, 6.0], [1.0, 2.0]), "finite"),
        (([], [], []), "a speed and two forces"),
    ],
)
def test_rows_that_are_no_table_are_refused_with_the_repair(rows: tuple[list[float], ...], reason: str) -> None:
    with pytest.raises(InputError, match=reason):
        force_table.from_rows(*rows)


def test_a_sheet_without_a_column_or_a_number_is_refused(tmp_path: Path) -> None:
    sheet = tmp_path / "dyno.csv"
    for text, reason in (
        ("speed (m/s), rebound (N)\n1, 2\n", r"no column is the compression \(there: .*call it 'compression \(N\)'"),
        ("speed, rebound (N), bump (N)\n1, 2, 3\n", r"the column 'speed' has no unit; .* units=\{'speed': 'm/s'\}"),
        ("speed (m/s), rebound (N), bump (N)\n1, 2, 3\n2, x, 4\n", "line 3"),
        ("speed (m/s), rebound (N), bump (N)\n1, 2, 3\n2,, 4\n", "line 3: the cell of the extension is empty"),
        ("speed (m/s), rebound (N), bump (N)\n", "numbers"),
    ):
        sheet.write_text(text)
        with pytest.raises(InputError, match=reason):
            force_table.from_sheet(sheet)


WIDTHS = {"w1": 0.005, "w2": 0.01, "w3": 0.015, "w4": 0.02, "w5": 0.03, "w6": 0.05}
RISES = {"e1": 60.0, "e2": 40.0, "e3": 20.0, "e4": 30.0, "e5": 25.0, "e6": 35.0}
RISES |= {"c1": 30.0, "c2": 20.0, "c3": 25.0, "c4": 10.0, "c5": 5.0, "c6": 15.0}


@pytest.mark.prove
def test_a_fit_of_six_sines_at_known_speeds_gives_the_rises_back() -> None:
    records = six_sines(damper("force_table", WIDTHS | RISES))
    result = fit(records, "force_table", fixed={f"force_table.{key}": value for key, value in WIDTHS.items()})
    assert result.converged, result.reason
    assert result.starts == (1, 1)  # all that is left is linear
    for key, value in RISES.items():
        assert result.parameters[f"force_table.{key}"] == pytest.approx(value, rel=0.01), key
    assert max(score.l1 for score in result.scores.values()) < 1e-3


@pytest.mark.prove
def test_a_fit_of_six_sines_finds_the_speeds_too() -> None:
    """From one point it ends at 0.4 %, a row within a straight piece; the last row's slopes are all that is known of it."""
    records = six_sines(damper("force_table", WIDTHS | RISES))
    assert max(score.l1 for score in fit(records, "force_table", starts=1).scores.values()) > 3e-3
    result = fit(records, "force_table")
    assert result.starts[0] == force_table.SEARCH_STARTS
    assert max(score.l1 for score in result.scores.values()) < 1e-3
    found = {key.partition(".")[2]: value for key, value in result.parameters.items()}
    for key, value in (WIDTHS | RISES).items():
        if not key.endswith("6"):
            assert found[key] == pytest.approx(value, rel=0.01), key
    for side in ("e6", "c6"):
        assert found[side] / found["w6"] == pytest.approx(RISES[side] / WIDTHS["w6"], rel=0.01)
