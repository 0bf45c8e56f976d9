"""Every command's help shows examples, and each of them runs."""

from __future__ import annotations

import shlex
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import click
import pytest
from click.testing import CliRunner
from tests.conftest import data_folder
from tests.example_folder import fill_example_folder

from dampyr.cli import cli
from dampyr.cli._examples import examples_of

ROOT = Path(__file__).resolve().parents[2]
SERVERS = ("console", "serve")
# More than three seconds each with kernels that are compiled already, or much more without: a proof.
LONG = (
    "demo", "reproduce", "hybrid", "identify", "calibrate", "run campaign.toml --out", "export damper.toml --to fmu",
    "simulate", "ensemble", "arena", "doctor --rig", "doctor --warm", "motion --pga",
    "accept damper.toml tests --tolerance 10%", "plan", "posterior",
)  # fmt: skip
ASKING = ("dampyr doctor --rig rig.toml --bring-up",)
NEEDS_DATA = ("reproduce", "datasets fetch")


def commands() -> Iterator[tuple[str, click.Command]]:
    """Every command, group and command of a group, by what is typed after ``dampyr``."""
    context = click.Context(cli)
    for name in cli.list_commands(context):
        command = cli.get_command(context, name)
        assert command is not None
        yield name, command
        yield from ((f"{name} {each}", sub) for each, sub in getattr(command, "commands", {}).items())


def marked(line: str) -> object:
    typed = line.removeprefix("dampyr ")
    # tests/stories/test_the_chain.py, a page of tests/test_docs.py and tests/test_kernel_warming.py run them
    if typed.startswith(("demo", "reproduce", "doctor --warm")):
        return pytest.param(line, marks=pytest.mark.by_hand)
    return pytest.param(line, marks=[pytest.mark.prove] * any(typed.startswith(each) for each in LONG))


EXAMPLES = list(dict.fromkeys(line for _, command in commands() for line in examples_of(command)))


@pytest.mark.parametrize(("name", "command"), list(commands()), ids=[name for name, _ in commands()])
def test_every_command_shows_examples_of_itself(name: str, command: click.Command) -> None:
    assert examples_of(command), f"dampyr {name} has no example: give the command epilog=examples(...)"
    assert all(line.startswith(f"dampyr {name}") for line in examples_of(command))
    shown = CliRunner().invoke(cli, [*name.split(), "--help"]).stdout
    assert "Examples:" in shown
    assert all(f"    {line}\n" in shown for line in examples_of(command))  # not folded
    assert all(len(line) <= 100 for line in examples_of(command))


def test_the_reference_shows_them() -> None:
    page = (ROOT / "docs" / "reference" / "commands.md").read_text(encoding="utf-8")
    assert not [line for line in EXAMPLES if line not in page]


@pytest.fixture(scope="module")
def prepared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with what the examples name: a card, records, a rig, a campaign, a motion, another laboratory's file."""
    folder = tmp_path_factory.mktemp("examples")
    fill_example_folder(folder)
    return folder


@pytest.mark.parametrize(
    "line", [marked(line) for line in EXAMPLES if not line.startswith(tuple(f"dampyr {s}" for s in SERVERS))]
)
def test_an_example_runs(
    line: str, prepared: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    words = shlex.split(line)[1:]
    if line.startswith(tuple(f"dampyr {each}" for each in NEEDS_DATA)):
        monkeypatch.setenv("DAMPYR_DATA", str(data_folder()))
        campaign = request.getfixturevalue("campaign_folder")
        words += (
            ["--from", str(campaign), *(() if "--to" in words else ("--to", "fetched"))] if "fetch" in words else []
        )
    monkeypatch.chdir(prepared)
    asks = line in ASKING  # of the first real boards: it is ended at the first question
    done = CliRunner().invoke(cli, words, input="q\n" if asks else "\n\n\n", catch_exceptions=False)
    assert done.exit_code == (130 if asks else 0), f"{line}\n{done.stderr}"
    assert done.stdout.strip()


def of_server(line: str) -> object:
    """tests/console/test_http_server.py starts a console in every run, and one example stands for both of another server."""
    long = line.startswith("dampyr console") or "--control" in line
    return pytest.param(line, marks=[pytest.mark.prove] * long)


@pytest.mark.parametrize(
    "line", [of_server(line) for line in EXAMPLES if line.startswith(tuple(f"dampyr {s}" for s in SERVERS))]
)
@pytest.mark.usefixtures("terminal_signals")
def test_a_server_of_an_example_starts_and_ends(line: str, prepared: Path) -> None:
    words = [*shlex.split(line)[1:], *(["--port", "0", "--no-browser"] if "console" in line else ["--opensees", "0"])]
    started = subprocess.Popen(
        [sys.executable, "-u", "-m", "dampyr", *words],
        cwd=prepared, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip
    assert started.stdout is not None
    try:
        said = next((text for text in started.stdout if "http" in text or "listening on" in text), "")
        assert said, "it ended before it listened"
        address = (
            said.split("http://")[1].split("/")[0]
            if "http" in said
            else f"127.0.0.1:{said.split('port ')[1].split(';')[0]}"
        )
        host, _, port = address.partition(":")
        socket.create_connection((host, int(port)), timeout=30).close()
        started.send_signal(signal.SIGINT)
        started.communicate(timeout=60)
    finally:
        started.kill()
        started.wait()
        started.stdout.close()
    assert started.returncode in (0, 2, 130)
