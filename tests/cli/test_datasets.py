"""``dampyr datasets``: what is here, and fetching from a local folder as from the network."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from dampyr.cli import cli


def run(*args: str | Path) -> Result:
    return CliRunner().invoke(cli, ["datasets", *map(str, args)], catch_exceptions=False)


def test_absent_data_say_how_to_get_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DAMPYR_DATA", str(tmp_path))
    (listed,) = json.loads(run("list", "--json").stdout)
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
    (listed,) = json.loads(run("list", "--json").stdout)
    assert (listed["state"], listed["missing_files"]) == ("complete", [])
    (tmp_path / "labcontrol-mr-damper" / "ensaio1.1.mat").unlink()
    (listed,) = json.loads(run("list", "--json").stdout)
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
