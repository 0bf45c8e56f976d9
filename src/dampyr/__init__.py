"""Test, identify and simulate magnetorheological dampers: from the shaking table to the building.

The packages are loaded on first access, so ``import dampyr`` is quick::

    import dampyr as dp

    records = dp.records.read_campaign("data/labcontrol-mr-damper")
    fit = dp.identification.fit(records, "dahl")
    response = dp.structures.respond(dp.structures.two_storey(), dp.ground_motions.el_centro(),
                                     dampers={1: fit.damper}, voltage=1.98)
"""

from importlib import import_module
from types import ModuleType

__version__ = "0.4.0.dev0"

_PACKAGES = (
    "records", "models", "identification", "ground_motions", "structures",
    "show", "export", "studies", "rig", "hybrid", "campaigns", "planning", "errors", "units", "registry",
)  # fmt: skip


def __getattr__(name: str) -> ModuleType:
    if name in _PACKAGES:
        return import_module(f"dampyr.{name}")
    raise AttributeError(f"module 'dampyr' has no attribute {name!r}; its packages are {', '.join(_PACKAGES)}")


def __dir__() -> list[str]:
    return sorted([*_PACKAGES, "__version__"])
