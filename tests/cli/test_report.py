"""The page of a command, and its figures as files."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from dampyr.cli import cli

COMMANDS = [
    "accept",
    "arena",
    "cycles",
    "demo",
    "ensemble",
    "hybrid",
    "identify",
    "judge",
    "motion",
    "posterior",
    "protocol",
    "reproduce",
    "run",
    "simulate",
    "specimens",
    "validate",
]


@pytest.mark.prove
def test_figures_are_left_beside_the_page(tmp_path: Path) -> None:
    page, folder = tmp_path / "motion.html", tmp_path / "figures"
    arguments = ["motion", "--report", str(page), "--figures", str(folder), "--json"]
    done = CliRunner().invoke(cli, arguments)
    assert done.exit_code == 0
    count = page.read_text("utf-8").count("<figure>")
    assert count > 0
    assert (
        len(list(folder.glob("*.svg"))) == len(list(folder.glob("*.pdf"))) == len(list(folder.glob("*.csv"))) == count
    )


def test_how_figures_look_is_said_with_where_they_go(tmp_path: Path) -> None:
    page = ["motion", "--report", str(tmp_path / "motion.html")]
    done = CliRunner().invoke(cli, [*page, "--decimal-comma"])
    assert done.exit_code == 2
    assert done.stderr == "dampyr: --decimal-comma is of the figures that --figures DIR writes; give it too\n"
    done = CliRunner().invoke(cli, [*page, "--figures", str(tmp_path), "--width", "88 V"])
    assert done.exit_code == 2
    assert "the unit 'V' does not measure what 'm' measures" in done.stderr
    done = CliRunner().invoke(cli, [*page, "--figures", str(tmp_path), "--width", "8.8 m"])
    assert done.stderr == "dampyr: width = 8800 mm is not allowed; a figure is 50 to 500 mm wide\n"
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("given", [["--figures", "x"], ["--pga", "0.3g", "--figures", "x"]])
def test_figures_without_a_page_are_refused_before_anything_is_done(given: list[str]) -> None:
    done = CliRunner().invoke(cli, ["motion", *given])
    assert done.exit_code == 2
    assert done.stderr == "dampyr: --figures are those of a page; give --report HTML too\n"


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_that_writes_a_page_offers_its_figures(name: str) -> None:
    command = cli.get_command(None, name)
    assert command is not None
    assert "figures" in {each.name for each in command.params}


def test_no_command_that_writes_a_page_is_left_out() -> None:
    folder = Path(__file__).parents[2] / "src" / "dampyr" / "cli"
    own = [
        path
        for path in folder.glob("[!_]*.py")
        if "figures_option" in (text := path.read_text("utf-8")) or "report_options" in text
    ]
    assert sorted(path.stem for path in own) == COMMANDS
    assert not [
        path for path in folder.glob("*.py") if '"--report"' in path.read_text("utf-8") and path.stem != "_report"
    ]
