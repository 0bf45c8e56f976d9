"""``dampyr cycles``: table, JSON, CSV, workbook and page, of one record and of several."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from openpyxl import load_workbook

import dampyr as dp
from dampyr.cli import cli


def run(*args: str | Path) -> Result:
    return CliRunner().invoke(cli, ["cycles", *map(str, args)], catch_exceptions=False)


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bilinear device without an input, and an oil damper at 0 and at 2 V."""
    lab = tmp_path_factory.mktemp("cycles")
    (lab / "oil").mkdir()
    t = np.arange(0.0, 4.0 + 1e-9, 0.0025)
    x, v = 0.01 * np.sin(2 * np.pi * t), 0.02 * np.pi * np.cos(2 * np.pi * t)
    force = dp.models.Damper("bilinear", {"Q": 900.0, "uy": 0.001, "k2": 1e5}).force(t, x, velocity=v)
    dp.records.write(dp.records.Record(t, x, force, no_input=True, name="steel"), lab / "steel.h5")
    for volts in (0.0, 2.0):
        force = (2000.0 + 1000.0 * volts) * v
        oil = dp.records.Record(t, x, force, voltage=volts, specimen="SN 1", name=f"oil-{volts:g}V")
        dp.records.write(oil, lab / "oil" / f"{oil.name}.h5")
    return lab


def test_one_record_has_a_row_for_each_cycle(lab: Path) -> None:
    shown = run(lab / "steel.h5", "--details")
    assert shown.exit_code == 0
    text = shown.stdout
    assert "Every full cycle" in text
    assert "equivalent damping" in text
    assert text.count(" 27.14") == 3  # %; the first begins at rest
    assert " 32.4" in text
    assert "Half cycles" not in text


def test_fewer_tables_are_printed_without_details(lab: Path) -> None:
    text = run(lab / "steel.h5").stdout
    assert "Every full cycle" not in text
    assert "more tables: add --details." in text


def test_units_are_those_that_are_asked_for(lab: Path) -> None:
    text = run(lab / "steel.h5", "--units", "in-lb").stdout
    assert "lbf/in" in text
    assert "in lbf" in text
    assert "N/mm" not in text
    refused = CliRunner().invoke(cli, ["cycles", str(lab / "steel.h5"), "--units", "yards"])
    assert refused.exit_code == 2


def test_json_is_in_si_and_has_no_damping_of_an_oil_damper(lab: Path) -> None:
    steel, oil = (
        json.loads(run(path, "--units", "in-lb", "--json").stdout)["records"][0]["cycles"][2]
        for path in (lab / "steel.h5", lab / "oil" / "oil-0V.h5")
    )
    assert steel["energy"] == pytest.approx(32.4, rel=1e-3)
    assert steel["effective_stiffness"] == pytest.approx(1.9e5, rel=1e-3)
    assert steel["damping_ratio"] == pytest.approx(0.2714, rel=1e-3)
    assert (oil["damping_ratio"], oil["loss_factor"]) == (None, None)
    assert oil["viscous_coefficient"] == pytest.approx(2000.0, rel=1e-3)


def test_tables_are_written_as_csv_and_as_a_workbook(lab: Path, tmp_path: Path) -> None:
    printed = run(lab / "oil", "--speed", "60mm/s", "--out", tmp_path / "tables").stdout
    assert "tables: " in printed
    with (tmp_path / "tables" / "cycles.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["record"] for row in rows] == ["oil-0V"] * 4 + ["oil-2V"] * 4
    energies = [float(row["energy [J]"]) for row in rows]
    assert energies == pytest.approx([2 * np.pi**2 * c * 0.01**2 for c in [2000.0] * 4 + [4000.0] * 4], rel=1e-3)
    run(lab / "oil", "--speed", "60mm/s", "--out", tmp_path / "tables.xlsx")
    book = load_workbook(tmp_path / "tables.xlsx")
    assert book.sheetnames[:4] == ["origin", "records", "levels", "cycles"]
    heads, *values = book["inputs"].iter_rows(values_only=True)
    inputs = [dict(zip(heads, row, strict=True)) for row in values if row[-1] is not None]
    assert [row["over softest"] for row in inputs] == pytest.approx([1.0, 2.0], rel=1e-3)
    refused = CliRunner().invoke(cli, ["cycles", str(lab / "oil"), "--out", "tables.pdf"])
    assert refused.exit_code == 2
    assert "tables.xlsx, or to a folder" in refused.stderr


def test_the_page_has_loops_tables_and_the_kinds_of_the_devices(lab: Path, tmp_path: Path) -> None:
    page = tmp_path / "cycles.html"
    printed = run(lab / "oil", "--speed", "60mm/s", "--report", page).stdout
    assert f"page: {page}" in printed
    html = page.read_text("utf-8")
    for heading in ("In short", "Loops", "Every cycle", "Force and speed", "Complex stiffness", "Force and input"):
        assert f">{heading}</h2>" in html
    assert "switched (a voltage or a current sets the force" in html
    assert html.count("<figure>") == 2
