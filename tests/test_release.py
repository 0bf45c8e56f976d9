"""What a release lacks is found, and a README on an index page has links that lead somewhere."""

import importlib.util
from pathlib import Path
from types import ModuleType

ROOT = Path(__file__).resolve().parents[1]
PROJECT = """
[project]
name = "dampyr"
[project.urls]
Repository = "https://example.org/dampyr"
Documentation = "https://example.org/dampyr/docs"
Changelog = "https://example.org/dampyr/changes"
Issues = "https://example.org/dampyr/issues"
"""
CITATION = """
authors:
  - family-names: Surname
    given-names: Name
version: 1.2.0
date-released: 2027-01-31
repository-code: https://example.org/dampyr
doi: 10.5281/zenodo.0000000
"""


def module(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    made = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    return made


def test_nothing_is_lacking_where_all_is_filled_in() -> None:
    check = module(ROOT / "tools" / "check_release.py")
    changes = "# Changes\n\n## [Unreleased]\n\n## [1.2.0] - 2027-01-31\n"
    assert check.list_lacking("1.2.0", PROJECT, CITATION, changes) == []
    planted = {
        "of development": ("1.2.0.dev0", PROJECT, CITATION, changes),
        "no heading": ("1.2.0", PROJECT, CITATION, "## [1.1.0] - 2026-01-01"),
        "names nobody": ("1.2.0", PROJECT, CITATION.replace("family-names: Surname", check.PLACEHOLDER), changes),
        "doi is missing": ("1.2.0", PROJECT, CITATION.replace("doi:", "# doi:"), changes),
        "has no Issues": ("1.2.0", PROJECT.replace("Issues = ", "Else = "), CITATION, changes),
        "version is 1.2.0, the package's is 1.3.0": ("1.3.0", PROJECT, CITATION, changes),
    }
    for words, texts in planted.items():
        assert any(words in line for line in check.list_lacking(*texts)), words


def test_each_python_of_the_classifiers_has_kernels_in_the_wheel() -> None:
    check = module(ROOT / "tools" / "check_release.py")
    project = '"Programming Language :: Python :: 3.11",\n"Programming Language :: Python :: 3.12",'
    names = ["dampyr/kernels/cpython-311-x86_64-unknown-linux-gnu.zip", "dampyr/kernels.py"]
    [lacking] = check.list_without_kernels(names, project)
    assert "Python 3.12" in lacking
    assert check.list_without_kernels([*names, "dampyr/kernels/cpython-312-arm64.zip"], project) == []


def test_links_of_the_readme_become_addresses() -> None:
    absolute = module(ROOT / "hatch_build.py").absolute
    text = "[how](docs/how-to/bench.md#a) ![picture](docs/a.png) [out](https://example.org) [here](#below)"
    assert absolute(text, "https://example.org/dampyr/") == (
        "[how](https://example.org/dampyr/blob/main/docs/how-to/bench.md#a) "
        "![picture](https://example.org/dampyr/raw/main/docs/a.png) [out](https://example.org) [here](#below)"
    )
    assert absolute(text, "") == text
    readme = absolute((ROOT / "README.md").read_text("utf-8"), "https://example.org/dampyr")
    assert "](docs/" not in readme
