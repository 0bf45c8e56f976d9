"""Test, identify and simulate magnetorheological dampers: from the shaking table to the building.

The packages are loaded on first access, so ``import dampyr`` is quick::

    import dampyr as dp

    records = dp.records.read_campaign("data/labcontrol-mr-damper")
    fit = dp.fit(records, "dahl")
    response = dp.respond(dp.structures.two_storey(), dp.ground_motions.el_centro(), dampers={1: fit.damper}, voltage=1.98)

``dp.read``, ``dp.fit``, ``dp.Damper`` and ``dp.respond`` are short for those of `dampyr.records`, `dampyr.identification`,
`dampyr.models` and `dampyr.structures`.
"""

from importlib import import_module
from typing import Any

__version__ = "0.4.0.dev0"

_PACKAGES = (
    "records", "models", "identification", "ground_motions", "structures",
    "show", "export", "studies", "rig", "hybrid", "campaigns", "planning", "errors", "units", "registry",
)  # fmt: skip
_SHORT = {"read": "records", "fit": "identification", "Damper": "models", "respond": "structures"}


def __getattr__(name: str) -> Any:
    if name in _PACKAGES:
        return import_module(f"dampyr.{name}")
    if name in _SHORT:
        return getattr(import_module(f"dampyr.{_SHORT[name]}"), name)
    raise AttributeError(f"module 'dampyr' has no attribute {name!r}; its packages are {', '.join(_PACKAGES)}")


def __dir__() -> list[str]:
    return sorted([*_PACKAGES, *_SHORT, "__version__"])
