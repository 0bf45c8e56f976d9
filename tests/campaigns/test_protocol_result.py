"""The figures of a protocol against a sheet of limits: what is judged, what is not, and how it is told."""

import json

import pytest
from click.testing import CliRunner
from tests.campaigns.made_response import TABLE, write_response

from dampyr.campaigns import judge_protocol
from dampyr.campaigns.protocol_result import ProtocolLimit
from dampyr.cli import cli
from dampyr.errors import FileError, InputError
from dampyr.records import read_campaign, write
from dampyr.show.pages import protocol_page


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_response(tmp_path_factory.mktemp("response") / "records", 0.02)


def sheet(tmp_path, text):
    path = tmp_path / "limits.csv"
    path.write_text(text)
    return path


def test_without_limits_nothing_is_judged(folder):
    result = judge_protocol(folder)
    assert (result.verdict, result.reasons) == ("not judged", ("no limits were given",))
    assert len(result.figures) == 8
    assert "verdict" in repr(result)


def test_every_limit_met_is_passed(folder, tmp_path):
    result = judge_protocol(folder, sheet(tmp_path, "quantity,high [ms],step\nt63,21,rise\nt90,47,\n"))
    assert (result.verdict, len(result.judged)) == ("passed", 3)


def test_one_figure_outside_fails_and_says_on_which_side(folder, tmp_path):
    result = judge_protocol(folder, sheet(tmp_path, "quantity,low [ms],high [ms]\nt63,,21\nt90,50,60\n"))
    assert result.verdict == "failed"
    assert [judged.reason for judged in result.judged] == ["", "", *["below the lower limit"] * 2]


def test_a_limit_that_covers_no_figure_leaves_the_verdict_open(folder, tmp_path):
    text = "quantity,high [ms],speed [mm/s],direction\nt63,30,30,extension\nt63,30,60,extension\n"
    result = judge_protocol(folder, sheet(tmp_path, text))
    assert result.verdict == "not judged"
    assert result.reasons == ("no figure is t63 under these conditions",)
    assert [judged.verdict for judged in result.judged] == ["passed", "not judged"]


def test_a_test_without_a_record_leaves_the_verdict_open(tmp_path):
    missing = write_response(tmp_path / "records", 0.02, TABLE | {"speeds": [0.03, 0.02]}, slice(0, 1))
    result = judge_protocol(missing, [ProtocolLimit("t63", None, 0.03)])
    assert result.verdict == "not judged"
    assert result.reasons == ("no complete record of 02-voltage_switch-12mm-20mmps-0V-1V",)


def test_a_figure_without_a_value_is_not_judged_with_its_reason(tmp_path):
    slow = write_response(tmp_path / "records", 0.2)
    result = judge_protocol(slow, [ProtocolLimit("settled", None, 0.001)])
    assert {judged.verdict for judged in result.judged} <= {"failed", "not judged"}
    assert all(judged.reason for judged in result.judged)


def test_a_record_that_gives_no_figure_is_not_judged_with_the_reason(tmp_path):
    """Such as that of a supply that gave no voltage, which is read back."""
    dead = write_response(tmp_path / "records", 0.02)
    record = read_campaign(dead, role=None)[0]
    write(record.replace(note="dead", voltage=0.0 * record.time), dead / f"{record.name}.h5")
    result = judge_protocol(dead, [ProtocolLimit("t63", None, 0.03)])
    assert result.verdict == "not judged"
    assert [judged.reason for judged in result.judged] == [
        f"{record.name}: its input has no step; record one that jumps between two levels"
    ]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("quantity,high\nt36,1\n", r"row 1: quantity = 't36' is not known"),
        ("quantity,high,colour\nt63,1,red\n", r"row 1: column 'colour' is not known"),
        ("quantity,high\nt63,\n", r"row 1: t63 has no limit"),
        ("quantity,low [ms],high [ms]\nt63,30,20\n", r"row 1: low = 30 ms is above high = 20 ms"),
        ("quantity,high\nt63,20 mm\n", r"row 1: .*mm"),
    ],
)
def test_a_mistake_in_the_sheet_is_told_with_its_row(folder, tmp_path, text, words):
    with pytest.raises(FileError, match=words):
        judge_protocol(folder, sheet(tmp_path, text))


def test_records_of_no_protocol_are_refused(tmp_path):
    (tmp_path / "a.csv").write_text(
        "time [s],displacement [mm],force [N]\n" + "".join(f"{k / 100},{k % 5},{k % 5}\n" for k in range(40))
    )
    with pytest.raises(InputError, match="its records are of no protocol"):
        judge_protocol(tmp_path)


def test_the_command_prints_criteria_writes_the_page_and_tells_the_verdict_by_its_exit_code(folder, tmp_path):
    path, page = sheet(tmp_path, "quantity,high [ms]\nt63,15\n"), tmp_path / "page.html"
    run = CliRunner().invoke(cli, ["protocol", str(folder), "--limits", str(path), "--report", str(page)])
    assert run.exit_code == 1, run.output
    assert "t63 <= 15 ms" in run.output
    assert "above the upper limit" in run.output
    html = page.read_text("utf-8")
    assert "t63 &lt;= 15 ms" in html
    assert "limits.csv" in html
    data = CliRunner().invoke(cli, ["protocol", str(folder), "--json"])
    assert data.exit_code == 3
    assert json.loads(data.stdout)["units"]["t63"] == "s"
    assert CliRunner().invoke(cli, ["protocol", str(folder), "--limits", "none.csv"]).exit_code == 2


def test_the_page_and_the_table_are_of_every_result(folder):
    result = judge_protocol(folder)
    assert "All figures" in protocol_page.html(result)
    assert list(result.to_dataframe()["quantity"][:2]) == ["dead_time", "t63"]
