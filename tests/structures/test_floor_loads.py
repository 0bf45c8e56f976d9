"""Loads on floors: their times, floors and tables."""

from pathlib import Path

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.structures import FloorLoads, quarter_car, read_loads, shear_building

TIME, FORCES = [0.0, 0.5, 2.0], {1: [0.0, 10.0, 4.0]}


def test_forces_are_linear_between_the_times_and_keep_their_last_value() -> None:
    loads = FloorLoads([0.5, 1.0, 3.0], {1: [0.0, 10.0, -4.0], "top": [0.0, 2.0, 2.0]})
    assert loads.at(np.array([0.0, 0.5, 0.75, 2.0, 3.0, 9.0])) == pytest.approx(
        np.array([[0.0, 0.0], [0.0, 0.0], [5.0, 1.0], [3.0, 2.0], [-4.0, 2.0], [-4.0, 2.0]])
    )
    assert loads.peaks == {"1": 10.0, "top": 2.0}
    assert loads.scaled(-2.0).at(np.array([2.0]))[0] == pytest.approx([-6.0, -4.0])
    assert loads.scaled(-2.0).history == ("scaled by -2",)


def test_quantities_are_converted() -> None:
    loads = FloorLoads(["0 ms", "10 ms"], {1: ["0 kN", "0.5 kN"]})
    assert (loads.duration, loads.peaks) == (0.01, {"1": 500.0})


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([0.0], {1: [0.0]}), "at least 2 finite numbers"),
        (([0.0, np.nan], {1: [0.0, 1.0]}), "at least 2 finite numbers"),
        (([0.0, 1.0, 1.0], {1: [0.0] * 3}), "goes from 1 to 1 s; it must rise"),
        (([-1.0, 1.0], {1: [0.0, 1.0]}), "is -1 s at first"),
        (([0.0, 1.0], {}), "mapping from floor"),
        (([0.0, 1.0], {1: [0.0, 1.0, 2.0]}), r"floor 1 have shape \(3,\); they must be 2"),
        (([0.0, 1.0], {1: [0.0, np.inf]}), "2 finite numbers in N"),
        (([0.0, 1.0], {1: [0.0, 1.0], "1": [0.0, 1.0]}), "given twice"),
        (([0.5, 1.0], {1: [3.0, 1.0]}), "begins at 0.5 s with 3 N on floor 1; begin with 0 N, or at 0 s"),
    ],
)
def test_wrong_loads_are_refused(arguments: tuple, message: str) -> None:
    with pytest.raises(InputError, match=message):
        FloorLoads(*arguments)


def test_a_factor_that_is_no_number_is_refused() -> None:
    with pytest.raises(InputError, match="not a finite number"):
        FloorLoads(TIME, FORCES).scaled(np.nan)


def test_floors_are_found_by_label_and_by_count() -> None:
    building = shear_building([1e3] * 3, [1e6] * 3, 0.02)
    rows = [0.0, 1.0]
    assert FloorLoads([0.0, 1.0], {"floor 3": rows, 1: rows, "Floor_2": rows}).floors_of(building) == (3, 1, 2)
    car = quarter_car(290.0, 45.0, 18e3, 190e3)
    assert FloorLoads([0.0, 1.0], {"sprung": rows, "1": rows}).floors_of(car) == (2, 1)
    with pytest.raises(InputError, match="no floor '4' in shear building to load; write a label, 1, 2, 3, or a count"):
        FloorLoads([0.0, 1.0], {4: rows}).floors_of(building)
    with pytest.raises(InputError, match="name one floor of shear building twice"):
        FloorLoads([0.0, 1.0], {"floor 3": rows, 3: rows}).floors_of(building)


def table(folder: Path, text: str) -> Path:
    path = folder / "wind.csv"
    path.write_text(text)
    return path


def test_a_table_has_its_units_in_the_header(tmp_path: Path) -> None:
    loads = read_loads(table(tmp_path, "time [ms],floor 1 [kN],roof [N]\n0,0,5\n100,1,-7\n500,0,0\n"))
    assert loads.time == pytest.approx([0.0, 0.1, 0.5])
    assert loads.peaks == {"floor 1": 1000.0, "roof": 7.0}
    assert (loads.name, loads.source) == ("wind", "wind.csv")


def test_units_are_declared_where_the_header_has_none(tmp_path: Path) -> None:
    path = table(tmp_path, "t;1;2\n0;0;0,5\n0,1;1;0\n")
    assert read_loads(path, "kN", "blow").peaks == {"1": 1000.0, "2": 500.0}
    with pytest.raises(
        InputError, match=r"the column 't' has no unit; write it in the header|the column '1' has no unit"
    ):
        read_loads(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0,1\n1,2\n", "names no columns"),
        ("floor 1 [N],floor 2 [N]\n0,1\n1,2\n", "0 columns of times"),
        ("time [s],floor 1 [s]\n0,1\n1,2\n", "does not measure"),
        ("time [s],floor 1 [N]\n0,1\n1,\n2,3\n", "empty cell"),
        ("time [s],floor 1 [N],floor 1 [kN]\n0,1,2\n1,2,3\n", "two columns called 'floor 1'"),
        ("time [s],floor 1 [N]\n1,1\n0,2\n", "wind.csv.*goes from 1 to 0 s"),
    ],
)
def test_wrong_tables_are_refused(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_loads(table(tmp_path, text))
