"""What a result shows is found by its type; text, notebook view, JSON, data frame and figure are functions of it."""

import importlib
import pkgutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import dampyr
from dampyr.errors import InputError
from dampyr.findings import Finding
from dampyr.origin import NOTICES, SIMULATED, Origin
from dampyr.show import descriptions
from dampyr.show.descriptions import DataFrameColumns, Description, describe, description_of
from dampyr.show.figures.ground_motion import ground_motion
from dampyr.show.table import Table
from dampyr.shown import Shown

SHOW = Path(dampyr.__file__).parent / "show"
FACES = {"figures", "pages"}


@dataclass(frozen=True, repr=False)
class Weighing(Shown):
    """A result of somebody else's, outside of dampyr."""

    mass: float
    origin: Origin = SIMULATED
    findings: tuple[Finding, ...] = (Finding("doubt", "the scale stood askew"), Finding("note", "it is an old scale"))


@describe.register
def describe_weighing(weighing: Weighing) -> Description:
    return Description(
        "Weighing",
        [("mass", f"{weighing.mass:g} kg")],
        tables=[lambda: Table(("mass", "of"), [[weighing.mass, "the damper"]], ("kg", ""))],
        figure=lambda: ground_motion([0.0, 1.0], [0.0, weighing.mass]),
        data=lambda: {"mass_kg": weighing.mass},
        frame=lambda: DataFrameColumns({"mass_kg": [weighing.mass]}, ["damper"], "what"),
    )


@dataclass(frozen=True, repr=False)
class Plain(Shown):
    """A result of which there is nothing but a title."""

    number: float


@describe.register
def describe_plain(plain: Plain) -> Description:
    return Description("Plain")


class Undescribed(Shown):
    """A result that nobody describes."""


def test_every_face_is_made_of_the_description() -> None:
    weighing = Weighing(2.5)
    text = repr(weighing).splitlines()
    assert text[0] == "<Weighing>"
    assert text[1].split(maxsplit=1) == ["origin", " ".join(NOTICES["simulated"].split())]
    assert "the scale stood askew" in text[2]
    assert "and 1 more finding" in text[3]
    assert text[4].split() == ["mass", "2.5", "kg"]
    html = weighing._repr_html_()
    for part in ("mass [kg]", "the damper", "<svg", "SIMULATED</text>"):
        assert part.lower() in html.lower()
    assert weighing.as_dict() == {"mass_kg": 2.5}
    frame = weighing.to_dataframe()
    assert (frame.index.name, float(frame.loc["damper", "mass_kg"])) == ("what", 2.5)
    axes = weighing.plot()
    assert np.ptp(axes[0].lines[0].get_ydata()) == pytest.approx(2.5)
    assert NOTICES["simulated"].partition(":")[0] in [one.get_text() for one in axes[0].figure.texts]


def test_what_a_result_does_not_have_is_said() -> None:
    plain = Plain(1.0)
    assert repr(plain) == "<Plain>"
    assert plain.as_dict() == {"number": 1.0}
    assert not hasattr(plain, "plot")
    with pytest.raises(InputError, match="Plain is not a table, so it makes no data frame"):
        plain.to_dataframe()
    with pytest.raises(
        TypeError, match=r"Undescribed has no description; register one with dampyr\.show\.descriptions"
    ):
        repr(Undescribed())


def test_a_subclass_shows_what_its_base_shows() -> None:
    class Heavier(Weighing):
        pass

    assert description_of(Heavier(9.0)).rows == [("mass", "9 kg")]


def subclasses(of: type) -> Iterator[type]:
    for kind in of.__subclasses__():
        yield kind
        yield from subclasses(kind)


def test_every_class_that_shows_itself_is_described_in_the_file_of_its_module() -> None:
    for module in pkgutil.walk_packages(dampyr.__path__, "dampyr."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    ours = {kind for kind in subclasses(Shown) if kind.__module__.startswith("dampyr.")}
    assert len(ours) > 70
    missing = set()
    for kind in ours:
        descriptions.load_descriptions(kind)
        if describe.dispatch(kind) is describe.dispatch(object):
            missing.add(kind.__name__)
    assert missing == set()


def test_every_file_of_a_package_describes_something_or_is_used_by_one_that_does() -> None:
    sources = {path: path.read_text("utf-8") for path in SHOW.rglob("*.py")}
    files = [path for path in sources if path.parent != SHOW and path.relative_to(SHOW).parts[0] not in FACES]
    unused = [
        str(path.relative_to(SHOW))
        for path in files
        if path.name != "__init__.py"
        and "@describe.register" not in sources[path]
        and not any(f"{path.parent.name}.{path.stem} import" in text for text in sources.values())
    ]
    assert unused == []


def test_notes_of_a_table_stand_below_its_caption_on_a_page(tmp_path: Path) -> None:
    from dampyr.show.pages.blocks import Section
    from dampyr.show.pages.html_page import page

    table: Any = Table(("x",), [[1.0]], caption="What it is.", notes=("x: a number.", "It is small."))
    assert "What it is. x: a number. It is small." in page("A page", [Section("One", [table])])
