"""``dampyr doctor`` tells what is there, and what is not."""

import json
import platform
import shutil
from importlib import metadata
from pathlib import Path

import pytest
from click.testing import CliRunner

from dampyr.cli import cli


def findings() -> dict[str, dict[str, str | None]]:
    result = CliRunner().invoke(cli, ["doctor", "--json"], catch_exceptions=False)
    assert result.exit_code == 0, result.stderr
    return {each["what"]: each for each in json.loads(result.stdout)}


def test_it_tells_what_is_there() -> None:
    by_name = findings()
    assert by_name["Python"]["found"] == platform.python_version()
    assert by_name["numba"]["found"] == metadata.version("numba")
    assert Path(str(by_name["compiled kernels"]["found"])).is_dir()


def test_it_tells_what_is_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DAMPYR_DATA", str(tmp_path))
    monkeypatch.setattr(shutil, "which", lambda name: None)
    by_name = findings()
    assert by_name["data set labcontrol"]["found"] == "absent"
    assert by_name["data set labcontrol"]["repair"] == "dampyr datasets fetch labcontrol"
    assert by_name["C compiler"]["found"] == "none"
    assert "gcc" in str(by_name["C compiler"]["repair"])


def test_people_get_a_table() -> None:
    shown = CliRunner().invoke(cli, ["doctor"], catch_exceptions=False).stdout
    assert shown.startswith("dampyr ")
    assert "numpy" in shown
