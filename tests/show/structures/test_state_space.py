"""What a state space shows: the shapes of its matrices, and what they mean."""

from dampyr.show.descriptions import description_of
from dampyr.structures import two_storey
from dampyr.structures.time_history.state_space import state_space


def test_the_shapes_are_those_of_two_floors_and_two_dampers() -> None:
    description = description_of(state_space(two_storey(), [1, 2]))
    assert description.title == "StateSpace of 2 floors and 2 dampers, SI"
    shapes = {name: words.partition(", ")[0] for name, words in description.rows}
    assert shapes == {"A": "4 × 4", "B": "4 × 2", "E": "4", "C": "2 × 4", "D": "2 × 2", "connection": "2 × 2", "F": "2"}


def test_a_single_damper_is_not_plural() -> None:
    assert description_of(state_space(two_storey(), 1)).title == "StateSpace of 2 floors and 1 damper, SI"
