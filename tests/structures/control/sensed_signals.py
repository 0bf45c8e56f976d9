"""What a law senses of a building."""

from dampyr.structures import control_law, two_storey
from dampyr.structures.control_laws import gains


def sensed(name, place=1, building=None, **settings):
    building = building or two_storey()
    return gains(control_law(name, high=3.0, **settings), building, building.connection(place))
