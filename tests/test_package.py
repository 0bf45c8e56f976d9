"""The package as people install it: the wheel and the sdist, what they say of themselves, and what a shell completes."""

import os
import re
import subprocess
import sys
import tarfile
import zipfile
from importlib import metadata
from pathlib import Path

import pytest
from click.testing import CliRunner
from packaging.version import Version

import dampyr
from dampyr.cli import cli
from dampyr.cli.help import SECTIONS
from tests.interpreters import run_text

ROOT = Path(__file__).resolve().parents[1]
NOT_SHIPPED = {".gitignore"}
DAMPYR = "from dampyr.cli import main\nmain()"


def tracked(folder: str) -> set[str]:
    """The files of a folder of this checkout, without what git ignores."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard", folder],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    if listed.returncode:
        pytest.skip("this is no git checkout, so there is no list of what belongs to the package")
    return {
        each for each in listed.stdout.splitlines() if (ROOT / each).is_file() and Path(each).name not in NOT_SHIPPED
    }


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the wheel and the sdist, built without a network."""
    folder = tmp_path_factory.mktemp("dist")
    code = (
        "import hatchling.build as b, sys\n"
        "print(b.build_sdist(sys.argv[1]))\nprint(b.build_wheel(sys.argv[1]))"
    )  # fmt: skip
    subprocess.run([sys.executable, "-c", code, str(folder)], cwd=ROOT, check=True, capture_output=True)
    return folder


@pytest.mark.prove
def test_the_wheel_holds_every_file_of_the_package(built: Path) -> None:
    [wheel] = built.glob("*.whl")
    names = set(zipfile.ZipFile(wheel).namelist())
    pages = {name for name in names if name.startswith("dampyr/docs/")}
    kernels = {name for name in names if name.startswith("dampyr/kernels/")}  # where somebody has made them
    assert {f"src/{name}" for name in names - pages - kernels if name.startswith("dampyr/")} == tracked("src/dampyr")
    listed = {name for name in tracked("docs") if name.endswith(".md") and name.split("/")[1] in SECTIONS}
    assert {name.removeprefix("dampyr/") for name in pages} == listed  # `dampyr help` prints them
    [about] = [name for name in names if name.endswith("METADATA")]
    text = zipfile.ZipFile(wheel).read(about).decode()
    assert re.search(r"^License-Expression: MIT$", text, re.MULTILINE)
    assert any(name.endswith("licenses/LICENSE") for name in names)
    assert "dampyr/py.typed" in names


@pytest.mark.prove
def test_the_sdist_builds_the_same_wheel(built: Path, tmp_path: Path) -> None:
    [sdist], [wheel] = built.glob("*.tar.gz"), built.glob("*.whl")
    with tarfile.open(sdist) as archive:
        archive.extractall(tmp_path, filter="data")
    [source] = tmp_path.iterdir()
    assert {"README.md", "LICENSE", "CITATION.cff", "pyproject.toml"} <= {each.name for each in source.iterdir()}
    code = "import hatchling.build as b, sys; print(b.build_wheel(sys.argv[1]))"
    subprocess.run([sys.executable, "-c", code, str(tmp_path)], cwd=source, check=True, capture_output=True)
    again = zipfile.ZipFile(tmp_path / wheel.name)
    assert sorted(again.namelist()) == sorted(zipfile.ZipFile(wheel).namelist())


@pytest.mark.prove
def test_the_wheel_runs_from_a_folder_of_its_own(built: Path, tmp_path: Path) -> None:
    [wheel] = built.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path)
    code = (
        "import sys; sys.path.insert(0, sys.argv[1])\nimport dampyr\nassert dampyr.__file__.startswith(sys.argv[1])\n"
        "from dampyr.cli import main\nsys.argv = ['dampyr', 'export', 'raminelli_2020', '--to', 'c', '--out', sys.argv[1]]\n"
        "main()"
    )
    done = subprocess.run([sys.executable, "-c", code, str(tmp_path)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "damper.c").is_file()


def test_the_citation_names_the_last_release() -> None:
    """Between releases the version is a development version of the next one, so that no two codes have the same."""
    text = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    last = re.findall(r"^## \[(\d+\.\d+\.\d+)\] - \d{4}-\d\d-\d\d$", changes, re.MULTILINE)[0]
    assert re.findall(r"^version: (.*)$", text, re.MULTILINE) == [last]
    version = Version(dampyr.__version__)
    assert version == Version(last) or (version.is_devrelease and version > Version(last))
    assert "license: MIT" in text


def test_every_licence_is_stated() -> None:
    extras = metadata.metadata("dampyr").get_all("Provides-Extra") or []
    options = [word for extra in extras if extra not in ("gpu", "seismology") for word in ("--extra", extra)]
    shown = CliRunner().invoke(cli, ["licences", *options, "--json"], catch_exceptions=False)
    rows = {row["name"]: row for row in __import__("json").loads(shown.stdout)}
    assert {"dampyr", "numpy", "scipy", "numba", "fastapi", "pyserial", "distributed", "nptdms"} <= set(rows)
    assert rows["dampyr"]["licence"] == "MIT"
    assert "BSD" in rows["scipy"]["licence"]
    assert [name for name, row in rows.items() if row["licence"] in ("none stated", "not installed")] == []
    strong = re.compile(r"\bA?GPL|(?<!Lesser )General Public", re.IGNORECASE)
    assert [name for name, row in rows.items() if strong.search(row["licence"]) and "LGPL" not in row["licence"]] == []


def test_an_unknown_extra_is_refused() -> None:
    shown = CliRunner().invoke(cli, ["licences", "--extra", "consol"])
    assert shown.exit_code != 0


@pytest.mark.parametrize(
    ("words", "at", "expected"), [("dampyr sim", 1, "simulate"), ("dampyr simulate --vol", 2, "--voltage")]
)
@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_shell_completes_commands_and_options(shell: str, words: str, at: int, expected: str) -> None:
    last = words.split()[-1]
    asks = {
        "COMP_WORDS": words,
        "COMP_CWORD": last if shell == "fish" else str(at),
        "_DAMPYR_COMPLETE": f"{shell}_complete",
    }
    done = run_text(DAMPYR, ("dampyr",), environment=os.environ | asks)
    assert expected in done.stdout


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_shell_gets_its_script(shell: str) -> None:
    done = run_text(DAMPYR, ("dampyr",), environment=os.environ | {"_DAMPYR_COMPLETE": f"{shell}_source"})
    assert "_DAMPYR_COMPLETE" in done.stdout
