"""A package of an extra that is not installed is said in one line, with the command that installs it, wherever it is missed."""

from __future__ import annotations

import os
import re
import subprocess
import tomllib
from pathlib import Path

import numpy as np
import pytest

from dampyr import records
from dampyr.models import Damper, Polynomial
from tests.interpreters import run_text

ROOT = Path(__file__).resolve().parents[1]
EXTRAS = [
    "serial", "nidaqmx", "grpc", "fastapi", "uvicorn", "websockets", "bokeh", "distributed", "nptdms", "openpyxl", "pyarrow",
    "obspy",
]  # fmt: skip
# Importing these fails as it does where they are not installed, in the processes that dampyr starts too.
WITHOUT = "import sys\nfor name in {names!r}:\n    sys.modules[name] = None\n"
COMMAND = "import sys\nfrom dampyr.cli import main\nsys.argv = ['dampyr', *{words!r}]\nmain()\n"

BY_COMMAND = [
    ("console", ["uvicorn"], ["console", "--data", "lab", "--no-browser", "--port", "0"]),
    ("console", ["fastapi"], ["console", "--data", "lab", "--no-browser", "--port", "0"]),
    ("console", ["websockets"], ["console", "--data", "lab", "--no-browser", "--port", "0"]),
    ("interop", ["nptdms"], ["records", "test.tdms"]),
    ("interop", ["openpyxl"], ["records", "test.xlsx"]),
    ("interop", ["openpyxl"], ["identify", "test.xlsx", "--model", "dahl"]),
    ("parquet", ["pyarrow"], ["records", "test.parquet"]),
    ("seismology", ["obspy"], ["motion", "test.mseed"]),
    ("interop", ["nptdms"], ["records", "convert", "test.tdms", "--out", "new"]),
    ("rig", ["serial"], ["run", "campaign.toml", "--out", "lab", "--rig", "rig.toml"]),
    ("rig", ["serial"], ["calibrate", "--rig", "rig.toml", "--yes"]),
]
BY_CALL = [
    ("console", ["uvicorn"], "import dampyr.console\ndampyr.console.serve('lab')"),
    ("console", ["fastapi"], "import dampyr.console\ndampyr.console.app('lab')"),
    ("interop", ["nptdms"], "import dampyr as dp\ndp.records.read('test.tdms')"),
    ("interop", ["openpyxl"], "import dampyr as dp\ndp.records.read('test.xlsx')"),
    ("interop", ["openpyxl"], "import dampyr as dp\ndp.records.read_campaign('sheets')"),
    ("parquet", ["pyarrow"], "import dampyr as dp\ndp.records.read('test.parquet')"),
    ("rig", ["serial"], "import dampyr as dp\ndp.rig.connect('rig.toml')"),
    (
        "gpu",
        ["numba.cuda"],
        "import dampyr as dp\ndp.structures.ensemble(dp.structures.two_storey(), dp.ground_motions.el_centro(), "
        "dp.models.Damper.load('damper.toml'), (0.0,), device='gpu')",
    ),
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Files that need the extras, and a campaign, a rig and a card."""
    place = tmp_path_factory.mktemp("without")
    for name in ("test.tdms", "test.xlsx", "test.parquet", "test.mseed"):
        (place / name).write_bytes(b"PK")
    (place / "sheets").mkdir()
    (place / "sheets" / "test.xlsx").write_bytes(b"PK")
    (place / "campaign.toml").write_text((ROOT / "examples" / "quick_campaign.toml").read_text("utf-8"), "utf-8")
    (place / "rig.toml").write_text('[wires]\nserial = "/dev/ttyACM0"\n')
    laws = {name: Polynomial((value,), 0.0, 3.0) for name, value in (("kx", 800.0), ("kw", 100.0), ("rho", 2e4))}
    Damper("dahl", {f"dahl.{name}": law for name, law in laws.items()}).save(place / "damper.toml")
    return place


def run(folder: Path, names: list[str], text: str) -> subprocess.CompletedProcess[str]:
    """Run a text of Python where ``names`` cannot be imported."""
    blocked = folder / f"without {' '.join(names)}"
    blocked.mkdir(exist_ok=True)
    (blocked / "sitecustomize.py").write_text(WITHOUT.format(names=names))
    path = os.pathsep.join([str(blocked), os.environ.get("PYTHONPATH", "")]).rstrip(os.pathsep)
    text = f"{WITHOUT.format(names=names)}{text}"  # the processes that it starts find the same in their sitecustomize
    return run_text(text, folder=folder, environment={**os.environ, "PYTHONPATH": path})


@pytest.mark.parametrize(("extra", "names", "words"), BY_COMMAND)
def test_a_command_says_it_in_one_line(folder: Path, extra: str, names: list[str], words: list[str]) -> None:
    done = run(folder, names, COMMAND.format(words=words))
    assert done.returncode == 2, done.stderr
    lines = done.stderr.strip().splitlines()
    assert f'pip install "dampyr[{extra}]"' in lines[-1]
    assert "Traceback" not in done.stderr
    assert lines[-1].startswith("dampyr: ")


@pytest.mark.parametrize(
    ("extra", "names", "text"),
    BY_CALL,
    ids=[f"{text.splitlines()[1][:40]} without {names[0]}" for _, names, text in BY_CALL],
)
def test_a_call_says_it_in_one_line(folder: Path, extra: str, names: list[str], text: str) -> None:
    done = run(folder, names, text)
    error = done.stderr.strip().splitlines()[-1]
    assert f'pip install "dampyr[{extra}]"' in error
    assert re.match(r"dampyr\.errors\.(InputError|FileError|RigFault): ", error)


def test_the_doctor_lists_every_extra() -> None:
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["optional-dependencies"]
    done = run_text(COMMAND.format(words=["doctor"]))
    assert done.returncode == 0, done.stderr
    assert not [extra for extra in extras if f"extra {extra}" not in done.stdout]
    [line] = [line for line in done.stdout.splitlines() if "extra interop" in line]
    assert "nptdms, openpyxl" in line.lower() or 'pip install "dampyr[interop]"' in line


def test_nothing_of_an_extra_is_loaded_with_dampyr(tmp_path: Path) -> None:
    """A record, a fit and a building need no extra: they run where none can be imported."""
    t = 0.01 * np.arange(400)
    x = 0.01 * np.sin(6 * t)
    records.write(
        records.Record(t, x, 200 * np.tanh(40 * np.gradient(x, t)), voltage=0.0, name="a"), tmp_path / "a.csv"
    )
    done = run(tmp_path, EXTRAS, COMMAND.format(words=["records", "a.csv", "--voltage", "0"]))
    assert done.returncode == 0, done.stderr


@pytest.mark.prove
@pytest.mark.parametrize("more", [[], pytest.param(["--real-time"], marks=pytest.mark.prove)])
def test_a_simulated_rig_needs_no_extra(folder: Path, tmp_path: Path, more: list[str]) -> None:
    """A campaign is performed where nothing of an extra can be imported, by the process that reads the rig either."""
    step = 'kind = "sine"\namplitude = "4 mm"\nfrequency = "2 Hz"\nvoltage = "0 V"\ncycles = 2\n'
    (folder / "short.toml").write_text(f'name = "short"\noperator = "me"\ncheck_amplitude = 0.0\n[[step]]\n{step}')
    done = run(folder, EXTRAS, COMMAND.format(words=["run", "short.toml", "--out", str(tmp_path / "out"), *more]))
    assert done.returncode == 0, done.stderr
    assert len(records.read_campaign(tmp_path / "out")) == 1
