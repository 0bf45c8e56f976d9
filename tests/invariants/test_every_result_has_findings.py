"""Whatever has an origin is a result, and says what a person should look at."""

import importlib
import pkgutil
from collections.abc import Iterator

import dampyr
from dampyr.shown import Shown

PARTS = {  # of a result that has them, or no result
    "Acceptance": "of one record, in Accepted",
    "Band": "of one record, in Validated",
    "Fragility": "in EnsembleResult",
    "Incremental": "of an ensemble's dataset",
    "Journal": "what was done, whose records have them",
    "Leaderboard": "in Fit",
    "Residuals": "in Fit",
    "Rig": "a rig; `diagnose` looks at it",
    "Validation": "in Fit",
    "VirtualRun": "a loop that is all computed, with its stability",
    "StudyRun": "published studies beside ours",
    "VrthsStudy": "a published benchmark beside ours",
}


def subclasses(of: type) -> Iterator[type]:
    for kind in of.__subclasses__():
        yield kind
        yield from subclasses(kind)


def has(kind: type, name: str) -> bool:
    return hasattr(kind, name) or name in getattr(kind, "__dataclass_fields__", {})


def test_what_has_an_origin_has_findings_or_is_part_of_what_has() -> None:
    for package in ("identification", "structures", "campaigns", "planning", "models", "records", "rig", "studies"):
        folder = importlib.import_module(f"dampyr.{package}")
        for module in pkgutil.walk_packages(folder.__path__, f"dampyr.{package}."):
            importlib.import_module(module.name)
    assert dampyr.__version__
    shown = {kind for kind in subclasses(Shown) if kind.__module__.startswith("dampyr.")}
    with_origin = {kind for kind in shown if has(kind, "origin")}
    without = {kind.__name__ for kind in with_origin if not has(kind, "findings")}
    assert without == set(PARTS)
    assert {"Record", "Fit", "Damper", "Response", "EnsembleResult", "Planned"} <= {k.__name__ for k in with_origin}
