"""``dampyr licences``: what the installed packages state of themselves."""

import json
from importlib import metadata
from typing import Any

import pytest
from click.testing import CliRunner, Result

from dampyr.cli import cli


def run(*args: str) -> Result:
    return CliRunner().invoke(cli, ["licences", *args], catch_exceptions=False)


def listed(*args: str) -> dict[str, dict[str, Any]]:
    done = run(*args, "--json")
    assert done.exit_code == 0, done.stderr
    return {row["name"]: row for row in json.loads(done.stdout)}


def test_dampyr_comes_first_and_what_it_needs_with_its_version() -> None:
    rows = listed()
    assert next(iter(rows)) == "dampyr"
    assert list(rows)[1:] == sorted(list(rows)[1:])
    for name in ("numpy", "scipy", "click", "llvmlite"):  # the last is needed by numba alone
        assert rows[name]["version"] == metadata.version(name)
    assert "BSD" in rows["scipy"]["licence"]
    assert all("\n" not in row["licence"] for row in rows.values())


def test_an_extra_adds_its_packages_and_an_unknown_one_is_a_sentence() -> None:
    without, with_console = listed(), listed("--extra", "console")
    assert set(without) < set(with_console)
    assert "fastapi" in set(with_console) - set(without)
    refused = run("--extra", "nothing")
    assert refused.exit_code == 2
    assert "there is no extra 'nothing'; choose from " in refused.stderr


def test_a_package_that_is_not_installed_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        metadata, "requires", lambda name: ["no-such-package; python_version > '3'", "never; python_version < '3'"]
    )
    assert listed()["no-such-package"] == {"name": "no-such-package", "version": None, "licence": "not installed"}
    assert "never" not in listed()
