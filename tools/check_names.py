"""Names that must not come back: old words as identifiers, modules that share a name or are hidden, import circles.

::

    python tools/check_names.py             # this checkout; exit status 1 and one line for each offence
    python tools/check_names.py --root DIR  # another one

- No identifier (NAME token of Python) holds one of `OLD_WORDS` as an underscore segment, in ``src``, ``tests``,
  ``benchmarks``, ``examples``, ``tools`` and ``docs``: these words say nothing of what a thing is (``result``, ``message``,
  ``options``, ``cached``, ``request`` do). The names of test functions are sentences and may hold any word. `ALLOWED` lists
  the exceptions, each with its reason.
- No two modules of ``src`` have the same name, except in the folders of `REGISTRIES`, whose files are named after what a
  user types or chooses: there the same name in two folders means the same thing. A file of ``show/PACKAGE`` has the name of
  the module of that package whose results it describes.
- No name that a package imports is that of one of its own modules or sub-packages: ``dampyr.records.cycles`` would be the
  function, and the module of that name could be reached by ``from`` alone.
- No modules import one another in a circle, neither when they are loaded nor inside of functions nor for types alone.
"""

from __future__ import annotations

import argparse
import ast
import sys
import tokenize
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

from measure import CHECKOUT, Module, import_circles, read_modules

FOLDERS = ("src", "tests", "benchmarks", "examples", "tools", "docs")
OLD_WORDS = {
    "found", "told", "known", "kept", "asked", "house", "room", "shelf", "lot", "lanes", "beside",
    "most", "longest", "fewest", "sharpest",
}  # fmt: skip
OLD_NAMES = {"_bent", "_settled"}  # three meanings of one, two of the other
ALLOWED = {
    "known_hash": "a parameter of pooch",
    "most_common": "a method of collections.Counter",
    "room": "the temperature of the room, a key of rig.toml",
}
REGISTRIES = (
    "campaigns/steps", "cli", "console/jobs", "console/pages", "export/kinds", "ground_motions/formats", "models/parts",
    "models/published", "records/formats", "show/figures", "structures/control",
)  # fmt: skip
PARTS = ("driver.py", "simulated.py")  # of every folder of rig/instruments


def main() -> int:
    """Print every offence; 1 where there is one."""
    parser = argparse.ArgumentParser(description="Old words, repeated or hidden module names, import circles.")
    parser.add_argument("--root", type=Path, default=CHECKOUT, metavar="DIR", help="the checkout to check")
    root = parser.parse_args().root.resolve()
    sources = list(read_modules(root / "src"))
    offences = [
        *(line for folder in FOLDERS for module in read_modules(root / folder) for line in old_words(module, root)),
        *repeated_modules(sources, root / "src" / "dampyr"),
        *hidden_modules(sources, root),
        *circle_lines(sources),
    ]
    print("\n".join(offences) or "No old words, no repeated or hidden module names, no import circles.")
    return 1 if offences else 0


def old_words(module: Module, root: Path) -> Iterator[str]:
    """One line for each identifier with an old word in it."""
    for token in module.tokens:
        if token.type != tokenize.NAME or token.string in ALLOWED or token.string.startswith("test_"):
            continue
        for word in sorted(OLD_WORDS & set(token.string.lower().split("_"))):
            yield f"{module.path.relative_to(root)}:{token.start[0]}: {token.string!r} holds {word!r}; name what it is"
        if token.string in OLD_NAMES:
            yield f"{module.path.relative_to(root)}:{token.start[0]}: {token.string!r} says nothing of what it does"


def repeated_modules(modules: list[Module], package: Path) -> Iterator[str]:
    """One line for each name that several modules outside of the registries have, or one outside and one in them."""
    places: dict[str, list[str]] = defaultdict(list)
    inside = [module.path.relative_to(package) for module in modules]
    described = {f"{place.parts[0]}/{place.stem}" for place in inside if len(place.parts) > 1}
    for module in modules:
        place = module.path.relative_to(package)
        if place.parts[0] == "show" and f"{place.parts[1]}/{place.stem}" in described:
            continue
        if not place.name.startswith("__") and place.parent.as_posix() not in REGISTRIES and place.name not in PARTS:
            places[place.stem].append(place.as_posix())
    for name, paths in sorted(places.items()):
        if len(paths) > 1:
            yield f"{len(paths)} modules are called {name!r}: {', '.join(paths)}; give each its own name"


def hidden_modules(modules: list[Module], root: Path) -> Iterator[str]:
    """One line for each name that a package takes from elsewhere and that one of its own modules or sub-packages has."""
    names = {module.name for module in modules}
    for package in (module for module in modules if module.is_package):
        for node in package.tree.body:
            if not isinstance(node, ast.ImportFrom) or node.module == package.name:
                continue
            for name in (alias.asname or alias.name for alias in node.names):
                if f"{package.name}.{name}" in names:
                    place = package.path.relative_to(root).as_posix()
                    yield f"{place}:{node.lineno}: {name!r} hides the module {package.name}.{name}; rename the module"


def circle_lines(modules: list[Module]) -> Iterator[str]:
    """One line for each circle of imports."""
    for circle in import_circles(modules)["with TYPE_CHECKING"]:
        yield f"import circle: {' <-> '.join(circle)}"


if __name__ == "__main__":
    sys.exit(main())
