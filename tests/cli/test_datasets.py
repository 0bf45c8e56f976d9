"""``dampyr datasets``: what is here, and fetching from a local folder as from the network."""

import json
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from dampyr.cli import cli
from dampyr.records import datasets


def run(*args: str | Path) -> Result:
    return CliRunner().invoke(cli, ["datasets", *map(str, args)], catch_exceptions=False)


def listed_set(name: str) -> dict[str, Any]:
    [one] = [each for each in json.loads(run("list", "--json").stdout) if each["name"] == name]
    return one


def test_absent_data_say_how_to_get_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DAMPYR_DATA", str(tmp_path))
    listed = listed_set("labcontrol")
    assert listed["name"] == "labcontrol"
    assert listed["state"] == "absent; dampyr datasets fetch labcontrol"
    assert listed["folder"] is None
    assert "zenodo" in listed["doi"]
    assert "dampyr datasets fetch labcontrol" in run("list").stdout


def test_fetch_from_a_folder_makes_a_complete_data_set(
    campaign_folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DAMPYR_DATA", str(tmp_path))
    result = run("fetch", "labcontrol", "--from", campaign_folder, "--json")
    assert result.exit_code == 0, result.stderr
    output = json.loads(result.stdout)
    assert len(output["files"]) == 40
    listed = listed_set("labcontrol")
    assert (listed["state"], listed["missing_files"]) == ("complete", [])
    (tmp_path / "labcontrol-mr-damper" / "ensaio1.1.mat").unlink()
    listed = listed_set("labcontrol")
    assert (listed["state"], listed["missing_files"]) == ("1 files missing", ["ensaio1.1.mat"])


def test_an_empty_source_is_refused(tmp_path: Path) -> None:
    result = run("fetch", "labcontrol", "--to", tmp_path / "to", "--from", tmp_path)
    assert result.exit_code == 2
    assert "there is no such file" in result.stderr
    assert result.stderr.count("\n") == 1


def test_an_unknown_data_set_lists_the_known_ones() -> None:
    result = run("fetch", "labcontrl")
    assert result.exit_code == 2
    assert "choose from labcontrol" in result.stderr


def test_a_group_alone_tells_its_commands() -> None:
    result = run()
    assert result.exit_code == 2
    assert "fetch" in result.stderr
    assert "list" in result.stderr


def test_the_list_fits_a_page_and_says_where_no_licence_is_stated() -> None:
    shown = run("list").stdout
    assert max(map(len, shown.splitlines())) <= 100
    [line] = [line for line in shown.splitlines() if "nees_2012_1158" in line]
    assert "none stated" in line
    assert "only as the law or\ntheir owner allows" in shown


@pytest.mark.parametrize("name", datasets.available_data_sets())
def test_one_set_is_shown_in_full(name: str) -> None:
    shown = run("show", name).stdout
    one = datasets.data_set(name)
    flat = " ".join(shown.split())
    assert all(
        text in flat for text in (one.title, one.citation, one.holds, one.good_for, one.licence_in_words, one.page)
    )
    assert not one.doi or one.doi in flat
    assert max(map(len, shown.splitlines())) <= 112  # an address cannot be folded
    assert json.loads(run("show", name, "--json").stdout)["holds"] == one.holds


def test_a_fetch_says_the_licence_and_how_to_cite(tmp_path: Path) -> None:
    (tmp_path / "mrdamper.mat").write_bytes(b"x")
    shown = run("fetch", "sano_wang_2008", "--from", tmp_path, "--to", tmp_path / "to").stdout
    assert "licence: none stated (" in shown
    assert "only as the law or their owner allows" in shown
    assert "please cite: J. Wang" in shown


def test_no_licence_is_no_download() -> None:
    result = run("fetch", "nees_2012_1158")
    assert result.exit_code == 2
    assert "states no licence" in result.stderr
    assert "--accept-no-licence" in result.stderr
