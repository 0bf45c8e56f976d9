"""A result as JSON and as a data frame: what its description says, else its fields and its first table."""

from dataclasses import dataclass

import pytest

from dampyr.errors import InputError
from dampyr.show.data import as_dict, as_frame
from dampyr.show.descriptions import DataFrameColumns, Description, describe
from dampyr.show.table import Table
from dampyr.shown import Shown


@dataclass(frozen=True, repr=False)
class Weights(Shown):
    """Fields and a table, and nothing else."""

    kilograms: tuple[float, ...]


class Heaviest(Weights):
    """With data and columns of its own."""


class Scale(Shown):
    """No dataclass, and without a table."""


@describe.register
def describe_weights(weights: Weights) -> Description:
    return Description(
        "Weights", tables=[lambda: Table(("mass", "place"), [[m, "shelf"] for m in weights.kilograms], ("kg", ""))]
    )


@describe.register
def describe_heaviest(weights: Heaviest) -> Description:
    heaviest = max(weights.kilograms)
    frame = DataFrameColumns({"mass_kg": [heaviest]}, ["heaviest"], "which")
    return Description("Heaviest", data=lambda: {"mass_kg": heaviest}, frame=lambda: frame)


@describe.register
def describe_scale(scale: Scale) -> Description:
    return Description("Scale")


def test_without_data_of_its_own_json_holds_the_fields_and_a_frame_the_first_table() -> None:
    weights = Weights((2.0, 3.5))
    assert as_dict(weights) == {"kilograms": (2.0, 3.5)}
    frame = as_frame(weights)
    assert list(frame.columns) == ["mass [kg]", "place"]
    assert list(frame["mass [kg]"]) == [2.0, 3.5]


def test_the_description_comes_first() -> None:
    heaviest = Heaviest((2.0, 3.5))
    assert as_dict(heaviest) == {"mass_kg": 3.5}
    frame = as_frame(heaviest)
    assert (frame.index.name, frame.loc["heaviest", "mass_kg"]) == ("which", 3.5)


def test_what_is_neither_is_said() -> None:
    with pytest.raises(InputError, match="Scale is not data that JSON holds"):
        as_dict(Scale())
    with pytest.raises(InputError, match="Scale is not a table, so it makes no data frame"):
        as_frame(Scale())
