"""No file of the repository carries somebody else's copyright notice or licence: what is needed of others is installed.

::

    python tools/check_copyright.py             # this checkout; exit status 1 and one line for each offence
    python tools/check_copyright.py --root DIR  # another one

- No line of a file that git knows holds a notice (the word or the sign with a year, a name or a second sign behind it) unless
  it names `OWNER`, nor a sentence of a licence, except in the file ``LICENSE`` at the root. `ALLOWED` lists the places that
  cite the terms of something that is not in the repository, each with its reason.
- No file is called as copies of others are: in a folder of `FOLDERS`, or with ``.min.`` in its name.

Where ``DIR`` is no checkout of git, every file below it is read.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

CHECKOUT = Path(__file__).resolve().parent.parent
OWNER = "The dampyr authors"
OWN_LICENCE = "LICENSE"
FOLDERS = {"vendor", "vendored", "third_party", "third-party", "node_modules"}
ALLOWED = {
    ("README.md", "zenodo.4445334"): "the terms of a data set, which is downloaded",
    (
        "src/dampyr/records/datasets/labcontrol.toml",
        "Labcontrol",
    ): "the terms of the same data set, shown to who downloads it",
    ("src/dampyr/records/datasets/labcontrol_motions.toml", "Labcontrol"): "the same, of its ground motions",
    (
        "src/dampyr/records/datasets/quiroz_2022.toml",
        "mequiroz",
    ): "the terms of another data set, shown to who downloads it",
    ("src/dampyr/records/datasets/vrths_2020.toml", "mequiroz"): "the same, of its ground motions",
    ("docs/reference/datasets.md", "Labcontrol"): "the page made from these files",
    ("docs/reference/datasets.md", "mequiroz"): "the page made from these files",
    ("tools/fingerprints/0.3.0.txt", "Labcontrol"): "what the data set says of itself",
}
NOTICE = re.compile(
    r"(?:\bcopyright|\u00a9)\W{0,12}(?:\(c\)|\u00a9|by\b|(?:19|20)\d\d)|\(c\)\s*(?:19|20)\d\d", re.IGNORECASE
)
TERMS = re.compile(
    r"all\s+rights\s+reserved|permission\s+is\s+hereby\s+granted|redistribution\s+and\s+use\s+in\s+source|"
    r"licen[sc]ed\s+under\s+the|spdx-licen[sc]e-identifier\s*:|gnu\s+(?:lesser\s+|affero\s+)?general\s+public",
    re.IGNORECASE,
)


def main() -> int:
    """Print every offence; 1 where there is one."""
    parser = argparse.ArgumentParser(description="Copyright notices of others in files of the repository.")
    parser.add_argument("--root", type=Path, default=CHECKOUT, metavar="DIR", help="the checkout to check")
    root = parser.parse_args().root.resolve()
    offences = [line for path in files(root) for line in offences_of(path, path.relative_to(root).as_posix())]
    print("\n".join(offences) or "No copyright notice of others.")
    return 1 if offences else 0


def files(root: Path) -> Iterator[Path]:
    """The files that git knows, and those that it would add; of a folder without git all."""
    listed = ["git", "-C", str(root), "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    run = subprocess.run(listed, capture_output=True, text=True) if (root / ".git").exists() else None
    names = run.stdout.split("\0") if run and run.returncode == 0 else [str(path) for path in sorted(root.rglob("*"))]
    yield from (root / name for name in names if name and (root / name).is_file())


def offences_of(path: Path, name: str) -> Iterator[str]:
    """One line for each offence of a file, called ``name`` from the root."""
    if FOLDERS & set(Path(name).parts[:-1]) or ".min." in Path(name).name:
        yield f"{name}: a copy of others' code by its name; let pip install it"
    for number, line in enumerate(path.read_text("utf-8", errors="replace").splitlines(), 1):
        allowed = any(name == place and words in line for place, words in ALLOWED)
        if NOTICE.search(line) and OWNER not in line and not allowed:
            yield f"{name}:{number}: a copyright notice of others: {line.strip()[:80]!r}"
        elif TERMS.search(line) and name != OWN_LICENCE:
            yield f"{name}:{number}: terms of a licence: {line.strip()[:80]!r}"


if __name__ == "__main__":
    sys.exit(main())
