"""Names that have two meanings: classes and modules that share a name, modules that are hidden, import circles.

::

    python tools/check_names.py             # this checkout; exit status 1 and one line for each offence
    python tools/check_names.py --root DIR  # another one

- No two classes of ``src`` have the same name.
- No two modules of ``src`` have the same name, except in the folders of `REGISTRIES`, whose files are named after what a
  user types or chooses: there the same name in two folders means the same thing. A file of ``show/PACKAGE`` has the name of
  the module of that package whose results it describes.
- No name that a package imports is that of one of its own modules or sub-packages: ``dampyr.records.cycles`` would be the
  function, and the module of that name could be reached by ``from`` alone.
- No modules import one another in a circle, neither when they are loaded nor inside of functions nor for types alone.

Whether a name says what a thing is, no list of words can check: a reader must.
"""

from __future__ import annotations

import argparse
import ast
import sys
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

from measure import CHECKOUT, Module, import_circles, read_modules

REGISTRIES = (
    "campaigns/steps", "cli", "console/jobs", "console/pages", "export/kinds", "ground_motions/formats", "models/parts",
    "models/published", "records/formats", "show/figures", "structures/control",
)  # fmt: skip
PARTS = ("driver.py", "simulated.py")  # of every folder of rig/instruments


def main() -> int:
    """Print every offence; 1 where there is one."""
    parser = argparse.ArgumentParser(description="Repeated class and module names, hidden modules, import circles.")
    parser.add_argument("--root", type=Path, default=CHECKOUT, metavar="DIR", help="the checkout to check")
    root = parser.parse_args().root.resolve()
    sources = list(read_modules(root / "src"))
    offences = [
        *repeated_classes(sources, root / "src" / "dampyr"),
        *repeated_modules(sources, root / "src" / "dampyr"),
        *hidden_modules(sources, root),
        *circle_lines(sources),
    ]
    print("\n".join(offences) or "No repeated names of classes or modules, no hidden modules, no import circles.")
    return 1 if offences else 0


def repeated_classes(modules: list[Module], package: Path) -> Iterator[str]:
    """One line for each name that several classes have."""
    places: dict[str, list[str]] = defaultdict(list)
    for module in modules:
        for node in ast.walk(module.tree):
            if isinstance(node, ast.ClassDef):
                places[node.name].append(f"{module.path.relative_to(package).as_posix()}:{node.lineno}")
    for name, lines in sorted(places.items()):
        if len(lines) > 1:
            yield f"{len(lines)} classes are called {name!r}: {', '.join(lines)}; give each its own name"


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
