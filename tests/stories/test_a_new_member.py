"""A new member of a catalogue is one file: in a copy of the repository one of each kind is added, and nothing is edited.

Then the lists are generated as `make docs` does, and what must pass is run in the copy: the invariants of the new members, the
checks of names and layers, the comparison of the pages with their generator, and a test that looks the members up in the
page of the packages, in the reference, on the command line and in the console.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("fastapi")

ROOT = Path(__file__).resolve().parents[2]
COPIED = ("src", "docs", "tools", "tests", "benchmarks", "examples")
FILES = ("README.md", "CHANGELOG.md", "CONTRIBUTING.md", "LICENSE", "Makefile", "pyproject.toml")
NAMES = "bent_dashpot or standstill or halfway or example_2026 or one_spring or parts"

STEP = r'''r"""Standstill: the table stands away from the middle, for what a specimen does at rest under pressure.

.. math:: x = x_0
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

from dampyr.campaigns.paths import GLIDE, around, driven, hold, top_speed
from dampyr.campaigns.step import Length, Peaks, Period, Rest, Time, Volts, check_ranges
from dampyr.rig import Drive, RigSettings


@dataclass(frozen=True)
class Standstill:
    """A rest away from the middle."""

    place: Annotated[float, Length, "from the middle of the stroke"]
    duration: Annotated[float, Time, "of the rest there"] = 5.0
    voltage: Annotated[float, Volts, "at the coil"] = 0.0
    rest_before: Annotated[float, Rest, "recorded, so that offsets can be read"] = 2.0
    period: Annotated[float, Period, "from set point to set point"] = 0.01

    lowers: ClassVar[tuple[str, ...]] = ("place", "voltage")
    named: ClassVar[tuple[str, ...]] = ("place", "duration", "voltage")
    fixed: ClassVar[bool] = False

    def __post_init__(self) -> None:
        check_ranges(self)

    def drive(self, rig: RigSettings) -> Drive:
        """The set points of table and coil."""
        return driven(around([hold(self.place, self.duration)], self.place, self.rest_before), self.period, self.voltage)

    def peaks(self, rig: RigSettings) -> Peaks:
        """The place, and the speed on the way there."""
        return Peaks(self.place, top_speed(self.place, GLIDE))
'''

LAW = r'''r"""Halfway: half of the range while the damper lengthens.

.. math:: u = \tfrac12 (u_{min} + u_{max}) \text{ if } \dot x > 0, \text{ else } u_{min}

An example.
"""

from dataclasses import dataclass

from dampyr.models.part import checked
from dampyr.structures.law_form import ControlLaw

MEASURES = ("rate",)


@checked
@dataclass(frozen=True)
class Halfway(ControlLaw):
    """The settings of every law, and no others."""


def decide(rate: float, low: float, high: float) -> float:
    return 0.5 * (low + high) if rate > 0.0 else low
'''

RECORD_FORMAT = '''"""JSON: an object with the lists time, displacement and force, in SI, and the voltage."""

import json
from pathlib import Path

import numpy as np

from dampyr.atomic_write import write_whole
from dampyr.errors import FileError
from dampyr.records.files.read_options import ReadOptions
from dampyr.records.record import Record

CHANNELS = ("time", "displacement", "force")


def read(path: Path, request: ReadOptions) -> Record:
    """The record in a ``.json`` file."""
    try:
        content = json.loads(path.read_text("utf-8"))
        channels = {name: np.array(content[name], dtype=float) for name in CHANNELS}
    except (ValueError, KeyError, TypeError) as problem:
        raise FileError(path, f"is no record in JSON ({problem!r}); write it with dp.records.write") from None
    return Record(**channels, **request.input_channels(content.get("voltage")), name=path.stem)


def write(record: Record, path: Path) -> Path:
    """Write time, displacement, force and a constant voltage."""
    content = {name: getattr(record, name).tolist() for name in CHANNELS}
    write_whole(path, json.dumps(content | {"voltage": record.voltage}))
    return path
'''

MOTION_FORMAT = '''"""Columns headed by their step: the first line has dt in s and the unit, each other one acceleration."""

from pathlib import Path

import numpy as np

from dampyr.errors import FileError
from dampyr.ground_motions.motion import GroundMotion
from dampyr.ground_motions.samples import motion_of

SUFFIXES = (".shake",)


def read(path: Path, units: str | None = None, dt: float | None = None) -> GroundMotion:
    """The ground motion of a .shake file."""
    try:
        first, *rest = path.read_text("utf-8").splitlines()
        step, unit = first.split()
        values = np.array(rest, dtype=float)
    except ValueError:
        raise FileError(path, "must begin with a line such as '0.01 g' and have one number on each other line") from None
    return motion_of(path, values, float(step), units or unit, source=path.name)
'''

PUBLISHED_SET = """model = "bouc_wen"
length = "m"
description = '''
An example: a small damper, a Bouc-Wen model linear in the voltage.
'''
claims = "an example of this test"
paper = "no paper: an example of this test"
where = "nowhere but here"
read = "this file, which is the source"
device = "a damper of 60 N for simulation"
input = "V"
limits = [0.0, 2.0]
limits_from = "as the test says"
notes = ["no specimen has these numbers"]

[motion]
amplitude = 0.01  # m
frequency = 1.0  # Hz
inputs = [0.0, 1.0, 2.0]

[printed]
c0a = [100.0, "N s/m"]
c0b = [50.0, "N s/(m V)"]
alpha_a = [5000.0, "N/m"]
alpha_b = [9000.0, "N/(m V)"]
gamma = [300.0, "1/m"]
beta = [300.0, "1/m"]
A = [1.2, "1"]
n = [1.0, "1"]
"""

STUDY = '''"""A damper that is a spring alone: every loop of it is a line."""

from dampyr.models import Constant, Damper


def damper() -> Damper:
    """500 N/m from 0 to 2 V."""
    return Damper("spring", {"spring.k0": Constant(500.0, 0.0, 2.0)})
'''

EXPORT = '''"""Table: the values of all parameters over the input, as CSV."""

from pathlib import Path

import numpy as np

from dampyr.atomic_write import write_whole
from dampyr.models import Damper


def write(damper: Damper, folder: Path, name: str, allow_extrapolation: bool = False) -> list[Path]:
    """Write ``name.csv``: one row for each of 21 inputs of the calibrated range."""
    folder.mkdir(parents=True, exist_ok=True)
    rows = [",".join(["input", *damper.composition.parameters])]
    for u in np.linspace(*damper.range, 21):
        rows.append(",".join(f"{value:.17g}" for value in (u, *damper.values(float(u)))))
    path = folder / f"{name}.csv"
    write_whole(path, "\\n".join(rows) + "\\n")
    return [path]
'''

COMMAND = '''"""Parts: the models that dampers are made of."""

from __future__ import annotations

import click

from dampyr.cli._output import as_json_option, print_json


@click.command()
@click.option("--containing", default="", help="Only names that have this text in them.")
@as_json_option
def command(containing: str, as_json: bool) -> None:
    """List the parts of dampers."""
    from dampyr import registry
    from dampyr.models.part import REGISTRY

    selected = [name for name in registry.names(REGISTRY) if containing in name]
    if as_json:
        print_json(selected)
        return
    for name in selected:
        click.echo(name)
'''

MEMBERS = {
    "campaigns/steps/standstill.py": STEP,
    "structures/control/halfway.py": LAW,
    "records/formats/json.py": RECORD_FORMAT,
    "ground_motions/formats/headed.py": MOTION_FORMAT,
    "models/published/example_2026.toml": PUBLISHED_SET,
    "studies/one_spring.py": STUDY,
    "export/kinds/table.py": EXPORT,
    "cli/parts.py": COMMAND,
}

LOOKED_UP = '''"""The new members where people look for them, and at work."""

import io
import json
import zipfile
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from fastapi.testclient import TestClient

from dampyr import ground_motions, records, studies
from dampyr.campaigns.kinds import kind
from dampyr.cli import cli
from dampyr.console import app
from dampyr.console.damper_files import zipped_export
from dampyr.models import published
from dampyr.structures import control_law

ROOT = Path(__file__).resolve().parents[1]
LISTED = ["bent_dashpot", "standstill", "halfway", ".json", ".shake", "one_spring", "table", "parts"]
REFERENCE = {
    "models": "## `bent_dashpot`", "campaign-file": "## `standstill`", "control-laws": "## `halfway`",
    "published": "## `example_2026`", "studies": "## `one_spring`", "commands": "## `dampyr parts`",
}  # fmt: skip
STEP = '[[step]]\\nkind = "standstill"\\nplace = "4 mm"\\n'


@pytest.fixture
def data(tmp_path):
    (tmp_path / "motions").mkdir()
    t = np.linspace(0.0, 4.0, 800)
    record = records.Record(t, 0.01 * np.sin(6 * t), 50 * np.cos(6 * t), voltage=1.0)
    records.write(record, tmp_path / "one.json")
    (tmp_path / "motions" / "weak.shake").write_text("0.01 g\\n" + "\\n".join(f"{0.1 * np.sin(k):.6f}" for k in range(500)))
    return tmp_path


@pytest.fixture
def client(data):
    with TestClient(app(data), base_url="http://127.0.0.1:8077") as test_client:
        yield test_client


@pytest.mark.parametrize("name", LISTED)
def test_the_page_of_the_packages_names_it(name):
    assert f"`{name}`" in (ROOT / "docs" / "reference" / "packages.md").read_text("utf-8")


@pytest.mark.parametrize("page", REFERENCE)
def test_the_reference_describes_it(page):
    assert REFERENCE[page] in (ROOT / "docs" / "reference" / f"{page}.md").read_text("utf-8")


def test_the_page_of_the_formats_has_three():
    text = (ROOT / "docs" / "reference" / "formats.md").read_text("utf-8")
    assert all(f"| `{name}` |" in text for name in (".json", ".shake", "table"))


def run(*args):
    done = CliRunner().invoke(cli, [*args, "--json"], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout)


def test_the_command_line_takes_them(data, tmp_path):
    assert run("parts", "--containing", "bent") == ["bent_dashpot"]
    [record] = run("records", str(data / "one.json"))["records"]
    assert record["name"] == "one"
    assert run("motion", str(data / "motions" / "weak.shake"))["dt_s"] == 0.01
    (tmp_path / "one.toml").write_text(STEP)
    assert "standstill" in json.dumps(run("run", str(tmp_path / "one.toml"), "--dry-run"))
    published.damper("example_2026").save(tmp_path / "card.toml")
    [path] = run("export", str(tmp_path / "card.toml"), "--to", "table", "--out", str(tmp_path))["written"]
    assert Path(path).read_text().startswith("input,bouc_wen.c0")
    accepted = CliRunner().invoke(cli, ["accept", "one_spring", str(data / "one.json")], catch_exceptions=False)
    assert "no published damper" not in accepted.output


def test_python_takes_them(data):
    assert control_law("halfway", high=2.0).high == 2.0
    assert studies.published_damper("one_spring").composition.names == ("spring",)
    assert ground_motions.read(data / "motions" / "weak.shake").n == 500
    assert records.read_campaign(data)[0].voltage == 1.0
    assert kind("standstill")(place=0.004).place == 0.004


def test_the_console_offers_them(client):
    choices = client.get("/api/identify/choices").json()
    assert "bent_dashpot" in choices["models"]
    assert choices["exports"]["table"] == "Table"
    offered = client.get("/api/building/choices").json()
    assert "halfway" in offered["laws"]
    assert {"example_2026", "one_spring"} <= {one["name"] for one in offered["dampers"]}
    assert offered["motions"] == ["weak.shake"]
    formats = client.get("/api/records/formats").json()
    assert all("json" in [one["name"] for one in formats[side]] for side in ("read", "written"))
    assert [one["key"] for one in client.get("/api/records/list").json()] == ["data/one.json"]
    exported = client.get("/api/records/export", params={"key": "data/one.json", "format": "json"})
    assert len(exported.json()["time"]) == 800
    uploaded = client.put("/api/records/uploads/two.json", content=exported.content)
    assert uploaded.status_code == 201, uploaded.text
    [kind] = [one for one in client.get("/api/campaigns/kinds").json() if one["name"] == "standstill"]
    plan = client.post("/api/campaigns/plan", json={"text": kind["text"]}).json()
    assert [one["words"] for one in plan["tests"]] == ["standstill 4 mm at 5 s, 0 V"]


def test_the_console_exports_a_damper_as_it():
    archive = zipfile.ZipFile(io.BytesIO(zipped_export(studies.one_spring.damper(), "table")))
    assert archive.namelist() == ["damper.csv"]
'''

CHECKED = {
    "looked up": ["tests/test_new_members.py"],
    "invariants": ["tests/invariants", "tests/models/test_published.py", "tests/cli/test_frame.py", "-k", NAMES],
    "checks": [
        "tests/test_registry.py", "tests/test_names.py", "tests/test_layers.py", "tests/test_docs.py",
        "tests/structures/test_control_laws.py", "tests/records/test_record_files.py",
        "tests/records/test_campaign_folder.py", "tests/campaigns/test_planned_tests.py", "tests/export/kinds/test_c.py",
        "-m", "not prove",
        "-k", "not violation and not offence and not has_its_reader_do and not python_in and not fits_as_they "
        "and not building_as and not c_of_the and not how_to_is",
    ],
}  # fmt: skip


def run(copy: Path, *args: str) -> subprocess.CompletedProcess[str]:
    """Python in the copy, with the sources of the copy."""
    environment = os.environ | {"PYTHONPATH": str(copy / "src")}
    return subprocess.run(
        [sys.executable, *args], cwd=copy, env=environment, capture_output=True, text=True, check=False
    )


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the repository with one new member of each catalogue, and its generated lists."""
    folder = tmp_path_factory.mktemp("copy") / "repository"
    for name in COPIED:
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__", "fixtures"))
    for name in FILES:
        shutil.copy(ROOT / name, folder)
    page = (ROOT / "docs" / "how-to" / "add-a-model.md").read_text("utf-8")
    part = re.search(r"^```python part=bent_dashpot\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    assert part, "the how-to shows a whole part"
    for name, text in {**MEMBERS, "models/parts/bent_dashpot.py": part[1]}.items():
        place = folder / "src" / "dampyr" / name
        assert not place.exists()
        place.write_text(text, encoding="utf-8")
    (folder / "tests" / "test_new_members.py").write_text(LOOKED_UP, encoding="utf-8")
    before = run(folder, "tools/make_docs.py", "--check")
    assert before.returncode == 1, before.stdout + before.stderr
    assert "run make docs" in before.stdout
    written = run(folder, "tools/make_docs.py")
    assert written.returncode == 0, written.stdout + written.stderr
    return folder


@pytest.mark.prove
@pytest.mark.parametrize(
    "tests",
    [pytest.param(tests, id=name, marks=[pytest.mark.by_hand] * (name == "checks")) for name, tests in CHECKED.items()],
)
def test_what_must_pass_passes_with_one_new_member_of_each_catalogue(copy: Path, tests: list[str]) -> None:
    done = run(copy, "-m", "pytest", "-q", "-p", "no:cacheprovider", *tests)
    assert done.returncode == 0, done.stdout[-6000:] + done.stderr[-2000:]


@pytest.mark.prove
def test_the_new_files_have_the_style_of_the_others(copy: Path) -> None:
    done = run(copy, "-m", "ruff", "check", "--no-cache", "src")
    assert done.returncode == 0, done.stdout
