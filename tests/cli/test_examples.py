"""Every command's help shows examples, and each of them runs."""

from __future__ import annotations

import shlex
import shutil
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import click
import numpy as np
import pytest
from click.testing import CliRunner
from tests.campaigns.made_response import write_response
from tests.campaigns.specimen_folders import QUASI_STATIC, dahl, specimen_folder
from tests.conftest import data_folder
from tests.ground_motions import accelerograph_files

from dampyr import records
from dampyr.cli import cli
from dampyr.cli._examples import examples_of
from dampyr.models import Damper, Polynomial
from dampyr.records import Record

ROOT = Path(__file__).resolve().parents[2]
SERVERS = ("console", "serve")
# More than three seconds each with kernels that are compiled already, or much more without: a proof.
LONG = (
    "demo", "reproduce", "hybrid", "identify", "calibrate", "run campaign.toml --out", "export damper.toml --to fmu",
    "simulate", "ensemble", "arena", "doctor --rig", "doctor --warm", "motion --pga",
    "accept damper.toml tests --tolerance 10%", "plan",
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
    laws = {"kx": (800.0, 300.0), "kw": (40.0, 180.0), "rho": (4e4, -8e3)}
    damper = Damper("dahl", {f"dahl.{name}": Polynomial(numbers, 0.0, 3.0) for name, numbers in laws.items()})
    damper.save(folder / "damper.toml")
    (folder / "tests").mkdir()
    for k, (voltage, amplitude) in enumerate(
        [(u, a) for u in (0.0, 1.0, 1.98) for a in (0.006, 0.01)] + [(1.0, 0.008)]
    ):
        records.write(
            simulated(damper, voltage, amplitude, f"test {k + 1}", validation=k == 6),
            folder / "tests" / f"test {k + 1}.h5",
        )
    shutil.copytree(folder / "tests", folder / "lab" / "SN1")
    (folder / "rig.toml").write_text('[wires]\ncoil_current = "ai1"\n')
    shutil.copy(ROOT / "examples" / "quick_campaign.toml", folder / "campaign.toml")
    t = 0.02 * np.arange(500)
    np.savetxt(folder / "kobe.csv", 0.3 * np.sin(9.0 * t) * np.exp(-0.3 * t))
    (folder / "motions").mkdir()
    for k, stream in enumerate(("HNE", "HNN", "HNZ")):
        accelerograph_files.esm(folder / "motions" / f"{stream}.asc", accelerograph_files.shaking(seed=k), stream)
    specimen_folder(folder / "specimen-17", QUASI_STATIC, dahl(300.0, 4000.0))
    (folder / "design.toml").write_text('[[level]]\namplitude = "4 mm"\nlargest_force = "300 N"\nenergy = "4.5 J"\n')
    rows = [f"{a:.3f};{8 * np.sin(6 * a):.4f};{0.3 * np.tanh(5 * np.cos(6 * a)):.4f}" for a in 0.004 * np.arange(1500)]
    (folder / "test.csv").write_text("t [s];x [mm];Load cell [kN]\n" + "\n".join(rows).replace(".", ","))
    write_response(folder / "response", 0.01)
    (folder / "wind.csv").write_text("time [s],floor 1 [N],floor 2 [kN]\n0,0,0\n0.5,300,0.2\n1,100,0.5\n4,0,0\n")
    (folder / "limits.csv").write_text("quantity,high [ms]\nt63,20\n")
    return folder


def simulated(damper: Damper, voltage: float, amplitude: float, name: str, validation: bool) -> Record:
    """A test of the damper, with noise of the load cell."""
    t = 0.005 * np.arange(1600)
    x = amplitude * np.sin(2.0 * np.pi * (0.5 + 50.0 * amplitude) * t)
    noise = np.random.default_rng(int(1e6 * amplitude)).normal(0.0, 1.0, t.size)
    return Record(
        t,
        x,
        damper.force(t, x, voltage=voltage) + noise,
        voltage=voltage,
        name=name,
        role="validation" if validation else "fit",
    )


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
