"""What a release still lacks, one line each; 1 where anything does.

::

    python tools/check_release.py          # builds into dist/ and checks
    python tools/check_release.py --quick  # without building
"""

from __future__ import annotations

import argparse
import re
import sys
import tomllib
import zipfile
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parents[1]
ADDRESSES = ("Repository", "Documentation", "Changelog", "Issues")
PLACEHOLDER = 'name: "The dampyr authors"'


def main() -> int:
    """Print what is missing; the exit status."""
    parser = argparse.ArgumentParser(description="What a release still lacks.")
    parser.add_argument("--quick", action="store_true", help="do not build")
    quick = parser.parse_args().quick
    read = {name: (CHECKOUT / name).read_text("utf-8") for name in ("pyproject.toml", "CITATION.cff", "CHANGELOG.md")}
    version = re.search(r'__version__ = "([^"]+)"', (CHECKOUT / "src/dampyr/__init__.py").read_text("utf-8"))
    assert version is not None
    lacking = list_lacking(version[1], read["pyproject.toml"], read["CITATION.cff"], read["CHANGELOG.md"])
    if not quick:
        lacking += list_unbuilt(CHECKOUT / "dist", version[1], read["pyproject.toml"])
    print("\n".join(lacking) or f"nothing is lacking for a release of {version[1]}")
    return 1 if lacking else 0


def list_lacking(version: str, project: str, citation: str, changes: str) -> list[str]:
    """What the texts lack."""
    lacking = []
    if "dev" in version:
        lacking.append(
            f"src/dampyr/__init__.py: __version__ = {version} is one of development; set it to the release's"
        )
    stated = re.search(r"^version: (\S+)", citation, re.MULTILINE)
    if stated is None or stated[1] != version:
        lacking.append(f"CITATION.cff: version is {stated[1] if stated else 'missing'}, the package's is {version}")
    if PLACEHOLDER in citation:
        lacking.append("CITATION.cff: authors names nobody; give family-names, given-names and orcid of each")
    lacking += [
        f"CITATION.cff: {key} is missing; {what}"
        for key, what in (
            ("date-released", "give the day of the release"),
            ("repository-code", "give the address of the repository"),
            ("doi", "give the DOI of this or, for the first one, reserve it"),
        )
        if not re.search(rf"^{key}: \S", citation, re.MULTILINE)
    ]
    urls = tomllib.loads(project)["project"].get("urls", {})
    lacking += [
        f"pyproject.toml: [project.urls] has no {name}; give its address"
        for name in ADDRESSES
        if not str(urls.get(name, "")).startswith("https://")
    ]
    if not re.search(rf"^## \[{re.escape(version)}\] - \d{{4}}-\d\d-\d\d", changes, re.MULTILINE):
        lacking.append(f"CHANGELOG.md: there is no heading '## [{version}] - DAY'")
    return lacking


def list_unbuilt(folder: Path, version: str, project: str) -> list[str]:
    """What the wheel and the source archive lack, built into ``folder`` without a network."""
    from hatchling import build

    folder.mkdir(exist_ok=True)
    names = build.build_sdist(str(folder)), build.build_wheel(str(folder))
    lacking = [f"{name}: is not of version {version}" for name in names if version not in name]
    with zipfile.ZipFile(folder / names[1]) as wheel:
        lacking += list_without_kernels(wheel.namelist(), project)
        about = next(name for name in wheel.namelist() if name.endswith("METADATA"))
        text = wheel.read(about).decode()
    relative = re.findall(r"\]\((?!https?://|#)([^)\s]+)\)", text)
    if relative:
        lacking.append(
            f"README.md: {len(relative)} links, the first to {relative[0]}, lead nowhere on an index page; they become "
            "addresses once [project.urls] has a Repository"
        )
    return lacking


def list_without_kernels(names: list[str], project: str) -> list[str]:
    """The versions of Python in the classifiers for which the files ``names`` of a wheel hold no kernels."""
    return [
        f"the wheel: no kernels for Python 3.{minor}; run tools/make_kernels.py with it, and build again"
        for minor in re.findall(r"Python :: 3\.(\d+)", project)
        if not any(name.startswith(f"dampyr/kernels/cpython-3{minor}-") for name in names)
    ]


if __name__ == "__main__":
    sys.exit(main())
