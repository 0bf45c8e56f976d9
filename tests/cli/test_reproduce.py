"""``dampyr reproduce``: the published study run again."""

import importlib
import json
from pathlib import Path
from typing import Any

import click
import pytest
from click.testing import CliRunner, Result
from tests.cli.asked_once import asked_once

from dampyr.cli import cli
from dampyr.studies import raminelli_2020


def run(*args: str | Path) -> Result:
    return CliRunner().invoke(cli, ["reproduce", *map(str, args)], catch_exceptions=False)


@pytest.fixture
def no_data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "empty").mkdir()
    monkeypatch.setenv("DAMPYR_DATA", str(tmp_path / "empty"))


@pytest.fixture(scope="module")
def reproductions() -> dict[str, Any]:
    """What was computed."""
    return {}


@pytest.fixture
def computed_once(reproductions: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """The study is computed once: these tests are of what is printed and written."""
    monkeypatch.setattr(raminelli_2020, "reproduce", asked_once(raminelli_2020.reproduce, reproductions))


@pytest.mark.parametrize("as_json", [False, True])
def test_what_the_study_gives_is_printed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, as_json: bool) -> None:
    """The study itself is run in tests/studies/test_raminelli_2020.py."""
    asked = []

    class Study:
        page = tmp_path / "out" / "reproduce.html"

        def as_dict(self) -> dict[str, Any]:
            return {"artefacts": {"(4.7)": {"verdict": "agrees"}}}

    def reproduce(data: Path | None, out: Path, progress: Any) -> Study:
        asked.append((data, out))
        return Study()

    monkeypatch.setattr(raminelli_2020, "reproduce", reproduce)
    monkeypatch.setattr(
        importlib.import_module("dampyr.cli.reproduce"), "print_result", lambda study: click.echo(study.as_dict())
    )
    result = run("--data", tmp_path, "--out", tmp_path / "out", *["--json"] * as_json)
    assert result.exit_code == 0, result.stderr
    assert asked == [(tmp_path, tmp_path / "out")]
    if as_json:
        assert json.loads(result.stdout) == Study().as_dict()
    else:
        assert "agrees" in result.stdout
        assert result.stdout.endswith(f"page: {Study.page}\n")


@pytest.mark.prove
@pytest.mark.usefixtures("no_data", "computed_once")
def test_without_data_it_does_the_rest_and_says_what_it_left_out(tmp_path: Path, reproductions: dict[str, Any]) -> None:
    reproductions.clear()
    result = run("--out", tmp_path / "out", "--json")
    assert result.exit_code == 0, result.stderr
    output = json.loads(result.stdout)
    assert output["data"] is None
    assert "dampyr datasets fetch labcontrol" in output["left_out"][0]
    assert output["artefacts"]["(4.7)"]["verdict"] == "agrees"
    assert output["artefacts"]["Table 4.2"]["verdict"] == "cannot be checked"
    assert output == json.loads((tmp_path / "out" / "reproduce.json").read_text("utf-8"))
    assert (tmp_path / "out" / "reproduce.html").is_file()


@pytest.mark.prove
@pytest.mark.usefixtures("no_data", "computed_once")
def test_people_get_a_line_for_each_artefact(tmp_path: Path) -> None:
    result = run("--out", tmp_path / "out")
    assert result.exit_code == 0, result.stderr
    for words in ("Table 4.1", "Figure 5.4", "Left out: everything that needs the measured files", "reproduce.html"):
        assert words in result.stdout


def test_a_folder_without_the_campaign_ends_in_one_line(tmp_path: Path) -> None:
    result = run("--data", tmp_path, "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert len(result.stderr.strip().splitlines()) == 1
    assert "dampyr datasets fetch labcontrol" in result.stderr
    assert not (tmp_path / "out").exists()


def test_plants_are_of_the_other_study(tmp_path: Path) -> None:
    result = run("--plants", "3", "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert "--plants is of vrths_2020; leave it out" in result.stderr
    result = run("ramineli")
    assert result.exit_code == 2
    assert (
        "'ramineli' is not a study; choose from ohtori_2004, quarter_car_2025, quiroz_2022, raminelli_2020"
        in result.stderr
    )


def test_the_studies_are_listed() -> None:
    assert "quarter_car_2025\n    A quarter car" in run("--list").stdout
    assert list(json.loads(run("--list", "--json").stdout)) == [
        "ohtori_2004", "quarter_car_2025", "quiroz_2022", "raminelli_2020", "spencer_1997", "vrths_2020",
    ]  # fmt: skip


@pytest.mark.prove
def test_a_study_that_is_a_list_of_numbers_is_printed_with_what_differs(tmp_path: Path) -> None:
    result = run("quarter_car_2025", "--out", tmp_path / "out")
    assert result.exit_code == 0, result.stderr
    assert "2 V                            travel                  29.4" in result.stdout
    assert "0 V, peak of the body: off by" in result.stdout
    assert "quarter_car_2025.html" in result.stdout
    numbers = json.loads((tmp_path / "out" / "quarter_car_2025.json").read_text("utf-8"))
    assert [value["verdict"] for value in numbers["compared"]].count("agrees") == 10


@pytest.mark.usefixtures("no_data")
def test_all_runs_what_it_can_and_names_the_rest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The dissertation, which needs a minute, is run in tests/studies."""
    from dampyr import studies

    names = ["ohtori_2004", "quarter_car_2025", "quiroz_2022", "vrths_2020"]
    monkeypatch.setattr(studies, "available_studies", lambda: names)
    result = run("--all", "--out", tmp_path / "out")
    assert result.exit_code == 0, result.stderr
    assert "ohtori_2004.html" in result.stdout
    assert "VIRTUAL" not in result.stdout  # which is not of all; a column says it
    assert result.stdout.count("virtual") == 2
    for name in ("quiroz_2022", "vrths_2020"):
        assert f"Left out: {name}: " in result.stdout
    for words in (["quiroz_2022", "--all"], ["--all", "--data", str(tmp_path)]):
        refused = run(*words)
        assert refused.exit_code == 2
        assert "--all" in refused.stderr


@pytest.mark.by_hand  # tests/studies/test_vrths_2020.py makes the same table and page
def test_the_hybrid_benchmark_is_a_table_and_a_page(data_root: Path, tmp_path: Path) -> None:
    result = run("vrths_2020", "--data", data_root / "vrths_2020", "--plants", "2", "--out", tmp_path / "out")
    assert result.exit_code == 0, result.stderr
    for words in (
        "sample controller",
        "Kalman",
        "2 random plants of case 4: 0 unstable",
        "numbers agree",
        "vrths_2020.html",
    ):
        assert words in result.stdout
    assert (tmp_path / "out" / "vrths_2020.json").is_file()
