"""What a law takes of a moment."""

from dampyr.structures import control_law, two_storey
from dampyr.structures.controller import design_controller


def sensed(name, place=1, building=None, argument=None, **settings):
    """The factors of the state and the ground's velocity (2n + 1,) in an argument of a law, its first by default."""
    building = building or two_storey()
    made = design_controller(control_law(name, high=3.0, **settings), building, building.connection(place)[None], 0)
    row = made.rows[made.formulas.arguments.index(argument) if argument else 0]
    return row[: 2 * building.n + 1]
