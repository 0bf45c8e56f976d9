"""The wheel in a new environment of each supported Python: the newcomer's page and the README's tour, each line as written.

By hand, as pip fetches the packages of each version: ``make endure NAME=other_pythons``. An interpreter is found as
``python3.12`` on the path or among pyenv's versions; one that is not there is skipped, and said.
"""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.stories.test_newcomer import PACKAGES, ROOT, VERSIONS, build_wheel, follow, run

TOUR = re.compile(r"^```(sh|python)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def interpreter(version: str) -> str:
    """The program of a Python of this version, or nothing."""
    roots = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    kept = sorted(str(path) for path in roots.glob(f"{version}.*/bin/python"))
    for program in (*kept, shutil.which(f"python{version}")):
        if program:
            asked = run([program, "-c", "import sys; print('%d.%d' % sys.version_info[:2])"], ROOT, dict(os.environ))
            if asked.stdout.strip() == version:
                return program
    return ""


@pytest.mark.by_hand
@pytest.mark.parametrize("version", VERSIONS)
def test_the_wheel_the_newcomers_page_and_the_tour(version: str, tmp_path: Path, campaign_folder: Path) -> None:
    program = interpreter(version)
    if not program:
        pytest.skip(f"no Python {version} is installed here")
    wheel = build_wheel(tmp_path)
    subprocess.run([program, "-m", "venv", str(tmp_path / "env")], check=True)
    programs = tmp_path / "env" / ("Scripts" if os.name == "nt" else "bin")
    pip = [str(programs / "python"), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, str(wheel), *PACKAGES], check=True)
    newcomer, tour = tmp_path / "newcomer", tmp_path / "tour"
    newcomer.mkdir()
    environment = follow(programs, newcomer)
    take_the_tour(programs, tour, environment, campaign_folder)


def take_the_tour(programs: Path, folder: Path, environment: dict[str, str], campaign: Path) -> None:
    """The commands and the Python of the README's tour; the data are those of this machine, where the index of data is not."""
    shutil.copytree(ROOT / "examples", folder / "examples")
    (folder / "data").mkdir()
    shutil.copytree(campaign, folder / "data" / "labcontrol-mr-damper")
    environment = environment | {"DAMPYR_DATA": str(folder / "data")}
    text = (ROOT / "README.md").read_text(encoding="utf-8").partition("## A quick tour")[2].partition("\n## ")[0]
    blocks = TOUR.findall(text)
    assert [kind for kind, _ in blocks] == ["sh", "python", "python"]
    commands = [line for line in blocks[0][1].splitlines() if "datasets fetch" not in line]
    assert len(commands) == 6
    for command in commands:
        done = run(["sh", "-c", command], folder, environment)
        assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"
    python = "".join(block for _, block in blocks[1:])
    done = run([str(programs / "python"), "-c", python], folder, environment)
    assert done.returncode == 0, done.stderr
    promised = re.findall(r"^print\(.*\)  # (.*)$", python, re.MULTILINE)
    assert len(promised) == 3
    assert done.stdout.splitlines() == promised
    assert "Traceback" not in done.stderr
