"""``dampyr records``: what was measured, and where a label disagrees."""

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from dampyr.cli import cli


def run(*args: str | Path) -> Result:
    return CliRunner().invoke(cli, ["records", *map(str, args)], catch_exceptions=False)


@pytest.fixture
def table(tmp_path: Path) -> Path:
    """Ten seconds of a 0.8 Hz, 20 mm peak-to-peak test, after two seconds of rest."""
    t = np.arange(0.0, 12.0, 0.01)
    x = np.where(t > 2.0, 10.0 * np.sin(2 * np.pi * 0.8 * (t - 2.0)), 0.0)
    f = 100.0 + 200.0 * np.sign(np.gradient(x)) * (t > 2.0)
    path = tmp_path / "sine.csv"
    rows = "\n".join(f"{a:.2f},{b:.6f},{c:.4f}" for a, b, c in zip(t, x, f, strict=True))
    path.write_text(f"time [s],displacement [mm],force [N]\n{rows}\n")
    return path


def test_a_file_is_measured(table: Path) -> None:
    result = run(table, "--voltage", "1.98", "--json")
    assert result.exit_code == 0, result.stderr
    (row,) = json.loads(result.stdout)["records"]
    assert row["name"] == "sine"
    assert (row["input"], row["input_value"]) == ("V", 1.98)
    assert row["measured"]["frequency_hz"] == pytest.approx(0.8, rel=1e-3)
    assert row["measured"]["peak_to_peak_m"] == pytest.approx(0.020, rel=5e-3)
    assert row["duration_s"] == pytest.approx(11.99)


def test_one_record_is_shown_in_full(table: Path) -> None:
    shown = dict(line.strip().split("   ", 1) for line in run(table).stdout.splitlines() if "   " in line.strip())
    fields = {name: words.split() for name, words in shown.items()}
    assert float(fields["frequency"][0]) == pytest.approx(0.8, rel=1e-3)
    assert float(fields["peak to peak"][0]) == pytest.approx(20.0, rel=5e-3)
    assert float(fields["peak speed"][0]) == pytest.approx(2 * np.pi * 0.8 * 10.0, rel=0.02)
    assert float(fields["mean force"][0]) == pytest.approx(100.0, abs=2.0)
    assert shown["samples"].strip() == "1200, every 0.01 s"
    assert [fields[name][1] for name in ("frequency", "peak to peak", "peak speed")] == ["Hz", "mm", "mm/s"]


def test_several_records_are_a_table_in_mm(table: Path) -> None:
    shown = run(table, table, "--voltage", "1.98").stdout.splitlines()
    assert shown[0] == "2 records"
    assert [line.split() for line in shown if "Hz" in line] == [["s", "Hz", "mm", "mm/s", "N"]]
    row = next(line for line in shown if line.strip().startswith("sine")).split()
    assert row[1:4] == ["fit", "1.98", "V"]
    assert [float(cell) for cell in row[4:7]] == pytest.approx([11.99, 0.8, 20.0], rel=5e-3)


def test_units_may_be_declared(tmp_path: Path, table: Path) -> None:
    bare = tmp_path / "bare.csv"
    bare.write_text(table.read_text().replace("displacement [mm]", "stroke").replace(" [N]", "").replace(" [s]", ""))
    options = [
        "--unit",
        "displacement=cm",
        "--unit",
        "force=N",
        "--unit",
        "time=s",
        "--column",
        "displacement=stroke",
    ]
    result = run(bare, *options, "--json")
    assert result.exit_code == 0, result.stderr
    (row,) = json.loads(result.stdout)["records"]
    assert row["measured"]["peak_to_peak_m"] == pytest.approx(0.200, rel=5e-3)


def test_a_record_without_a_cycle_is_still_listed(tmp_path: Path, table: Path) -> None:
    rest = tmp_path / "rest.csv"
    rest.write_text("\n".join(table.read_text().splitlines()[:150]) + "\n")
    result = run(rest, "--json")
    assert result.exit_code == 0, result.stderr
    (row,) = json.loads(result.stdout)["records"]
    assert row["measured"] is None
    assert "cycle" in row["findings"][0]["words"]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("0.5", "nan"), "finite"),
        (("force [N]", "force [furlong]"), "furlong"),
        (("time [s]", "moment [s]"), "time"),
    ],
)
def test_a_bad_file_is_one_line_that_names_it(table: Path, change: tuple[str, str], words: str) -> None:
    header, *rows = table.read_text().splitlines()
    if change[1] == "nan":
        rows[50] = "0.50,nan,100.0"
    table.write_text("\n".join([header.replace(*change), *rows]))
    result = run(table)
    assert result.exit_code == 2
    assert result.stderr.startswith(f"dampyr: {table}")
    assert words in result.stderr
    assert result.stderr.count("\n") == 1


def test_a_channel_must_be_named(table: Path) -> None:
    result = run(table, "--unit", "mm")
    assert result.exit_code == 2
    assert "--unit 'mm' has no '='; write it as in CHANNEL=UNIT" in result.stderr


@pytest.mark.prove
def test_the_campaign_is_listed_with_its_disagreement_and_its_missing_rows(campaign_folder: Path) -> None:
    result = run(campaign_folder, "--json")
    assert result.exit_code == 0, result.stderr
    output = json.loads(result.stdout)
    assert len(output["records"]) == 39
    assert [each["name"] for each in output["records"] if each["role"] == "validation"] == ["ensaio.vali.1"]
    noted = {each["name"]: each["findings"] for each in output["records"] if each["findings"]}
    assert list(noted) == ["ensaio10.2.2"]
    assert "labelled 0.8474 Hz" in noted["ensaio10.2.2"][0]["words"]
    assert output["rows_without_file"] == [{"table": "4.4", "row": 2}, {"table": "4.4", "row": 4}]


def test_the_record_of_a_role_is_shown_alone(campaign_folder: Path) -> None:
    result = run(campaign_folder, "--role", "validation", "--json")
    assert result.exit_code == 0, result.stderr
    assert [record["name"] for record in json.loads(result.stdout)["records"]] == ["ensaio.vali.1"]


@pytest.mark.prove
def test_a_role_can_be_chosen(campaign_folder: Path) -> None:
    shown = run(campaign_folder, "--role", "fit").stdout
    assert shown.startswith("38 records")
    assert "vali" not in shown
    assert "table 4.4, row 2: no file" in shown
