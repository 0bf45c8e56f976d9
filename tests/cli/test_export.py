"""``dampyr export``: a damper in other people's tools."""

from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from dampyr.cli import cli
from dampyr.models import published


def run(*args: str | Path) -> Result:
    return CliRunner().invoke(cli, ["export", *map(str, args)], catch_exceptions=False)


@pytest.mark.prove
def test_a_lag_is_left_out_by_name_for_an_inverse(tmp_path: Path) -> None:
    card = published.damper("tan_agrawal_2004").save(tmp_path / "card.toml")
    refused = run(card, "--to", "c", "--out", tmp_path, "--inverse")
    assert refused.exit_code == 2
    assert "or with --without lag, and let what acts follow the command u_c: u' = (u_c - u)/" in refused.stderr
    assert run(card, "--to", "c", "--out", tmp_path, "--inverse", "--without", "lag").exit_code == 0
    assert run(card, "--to", "c", "--out", tmp_path / "command").exit_code == 0
    assert "double command, acting;" in (tmp_path / "command" / "damper.h").read_text()
