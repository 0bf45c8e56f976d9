"""``dampyr export``: a damper in other people's tools."""

from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from dampyr.cli import cli
from dampyr.models import published


def run(*args: str | Path) -> Result:
    return CliRunner().invoke(cli, ["export", *map(str, args)], catch_exceptions=False)


@pytest.mark.prove
def test_a_lag_is_left_out_by_name_for_c(tmp_path: Path) -> None:
    card = published.damper("spencer_1997").save(tmp_path / "card.toml")
    refused = run(card, "--to", "c", "--out", tmp_path)
    assert refused.exit_code == 2
    assert "or with --without lag, and filter the command u_c before: u' = (u_c - u)/0.00526316 s" in refused.stderr
    assert run(card, "--to", "c", "--out", tmp_path, "--without", "lag").exit_code == 0
    assert (tmp_path / "damper.c").exists()
