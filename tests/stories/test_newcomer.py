"""The tutorial for a newcomer, followed in an environment of its own in which the wheel is installed, from its text alone.

What is printed is compared with what the page says. The wheel is installed without its dependencies, which come from this
environment, so that no index is needed; with ``DAMPYR_NEWCOMER=index`` pip installs all of them as the page has it.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
import sysconfig
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "tutorials" / "newcomer.md"
FENCE = re.compile(r"^```([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
PACKAGES = ["fmpy", "openseespy"]
VERSIONS = ("3.11", "3.12", "3.13")
# openseespy is this module and a choice of the package for the system.
OPENSEESPY = "from openseespylinux.opensees import *\n"


def steps() -> Iterator[tuple[str, str, list[str]]]:
    """What the reader does, in order: ("save", name, lines) and ("type", command, lines that are printed then)."""
    for kind, text in FENCE.findall(PAGE.read_text(encoding="utf-8")):
        if named := re.match(r"# (\S+\.(?:py|toml))\n", text):
            yield "save", named[1], text.splitlines()
        elif kind == "sh":
            yield "type", text.strip(), []
        elif kind == "text":
            yield "see", "", text.splitlines()


def run(command: list[str], folder: Path, environment: dict[str, str]) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)


def build_wheel(tmp_path: Path, more: dict[str, bytes] | None = None) -> Path:
    """The wheel of these sources, and of ``more`` files."""
    source = tmp_path / "source"
    source.mkdir()
    for name in ("pyproject.toml", "hatch_build.py", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    for name in ("src", "docs"):
        shutil.copytree(ROOT / name, source / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name, content in (more or {}).items():
        (source / name).parent.mkdir(parents=True, exist_ok=True)
        (source / name).write_bytes(content)
    built = run(
        [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(tmp_path)], source, dict(os.environ)
    )
    assert built.returncode == 0, built.stderr
    [wheel] = tmp_path.glob("*.whl")
    return wheel


@pytest.fixture
def installed(tmp_path: Path) -> Path:
    """The folder of the programs of a new environment with the wheel of these sources."""
    wheel = build_wheel(tmp_path)
    env = tmp_path / "env"
    subprocess.run([sys.executable, "-m", "venv", str(env)], check=True)
    programs = env / ("Scripts" if os.name == "nt" else "bin")
    pip = [str(programs / "python"), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    if os.environ.get("DAMPYR_NEWCOMER") == "index":
        subprocess.run([*pip, str(wheel), *PACKAGES], check=True)
        return programs
    subprocess.run([*pip, "--no-deps", "--no-index", str(wheel)], check=True)
    own = Path(
        run(
            [str(programs / "python"), "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"], tmp_path, {}
        ).stdout.strip()
    )
    # A line of a .pth is searched last, and no .pth in that folder is read: dampyr itself is the wheel's.
    (own / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    (own / "openseespy").mkdir()
    (own / "openseespy" / "opensees.py").write_text(OPENSEESPY)
    return programs


@pytest.mark.prove
def test_a_newcomer_gets_from_a_csv_to_a_card_a_prediction_an_fmu_and_a_building(
    installed: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "reader"
    folder.mkdir()
    environment = follow(installed, folder)
    typed = [sys.executable, "-m", "mypy", "--python-executable", str(installed / "python"), "predict.py"]
    checked = run(typed, folder, environment)
    assert checked.returncode == 0, checked.stdout  # the wheel is typed


def follow(installed: Path, folder: Path) -> dict[str, str]:
    """Do what the page says in ``folder``, with these programs; the environment that it was done in."""
    environment = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "DAMPYR_DATA")}
    environment["PATH"] = os.pathsep.join([str(installed), environment.get("PATH", "")])
    where = run([str(installed / "python"), "-c", "import dampyr; print(dampyr.__file__)"], folder, environment)
    assert Path(where.stdout.strip()).is_relative_to(installed.parent), where.stderr
    printed, commands = "", 0
    for kind, what, lines in steps():
        if kind == "save":
            (folder / what).write_text("\n".join([*lines, ""]), encoding="utf-8")
        elif kind == "see":
            missing = [line for line in lines if " ".join(line.split()) not in " ".join(printed.split())]
            assert not missing, printed
        else:
            words = shlex.split(what)
            if "run_building.py" in words and (why := no_opensees(installed, folder, environment)):
                pytest.skip(f"OpenSees cannot be loaded here: {why}")
            done = run([str(installed / words[0]), *words[1:]], folder, environment)
            printed = done.stdout + done.stderr
            assert "Traceback" not in printed, f"{what}\n{printed}"
            assert done.returncode == (0 if (folder / "tests" / "reading.toml").exists() or "make" in what else 2), (
                printed
            )
            commands += 1
    assert commands == 11
    return environment


def no_opensees(programs: Path, folder: Path, environment: dict[str, str]) -> str:
    """Why openseespy cannot be imported, or nothing."""
    done = run([str(programs / "python"), "-c", "import openseespy.opensees"], folder, environment)
    return done.stderr.strip().splitlines()[-1] if done.returncode else ""


def test_the_tutorial_lists_every_extra_and_the_readme_the_versions_that_were_tested() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    listed = re.findall(r"^\| `(\w+)` \|", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    assert sorted(listed) == sorted(project["optional-dependencies"])
    versions = [each.rpartition(" ")[2] for each in project["classifiers"] if re.search(r"Python :: 3\.", each)]
    readme = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    first, *others = versions
    assert f"All tests are run with Python {first}, on Linux. On {' and '.join(others)} [a part of them ran]" in readme
    assert versions == list(VERSIONS)
    assert "Typing :: Typed" in project["classifiers"]
