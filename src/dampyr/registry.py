"""Registry of the members of a package: one per file, looked up by the file's name.

Adding a model, an earthquake format or a command is adding one file; nothing else lists them.
"""

from collections.abc import Iterator
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType

from dampyr.errors import InputError, choose_from


def summary(module: ModuleType) -> str:
    """The first paragraph of a member's docstring in one line, without the full stop: what it is, for lists."""
    return " ".join((module.__doc__ or "").partition("\n\n")[0].split()).rstrip(".")


def title(module: ModuleType) -> str:
    """What a member is called in a list: its `summary` up to the first colon."""
    return summary(module).partition(":")[0]


def names(package: str) -> list[str]:
    """The names of the members, sorted: the public modules of the package called ``package``."""
    folder = import_module(package)
    return sorted(m.name for m in iter_modules(folder.__path__) if not m.name.startswith("_"))


def member(package: str, name: str) -> ModuleType:
    """The module called ``name`` of a package, or an :class:`InputError` that lists the members."""
    available = names(package)
    if name not in available:
        label = getattr(import_module(package), "MEMBERS", package.rpartition(".")[2].replace("_", " "))
        raise InputError(f"{name!r} is not among the {label}; {choose_from(name, available)}")
    return import_module(f"{package}.{name}")


def members(package: str) -> Iterator[tuple[str, ModuleType]]:
    """Every ``(name, module)`` of a registered package."""
    for name in names(package):
        yield name, member(package, name)
