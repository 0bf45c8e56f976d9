"""What a state space shows."""

from __future__ import annotations

from dampyr.phrases import counted
from dampyr.show.descriptions import Description, describe
from dampyr.structures.time_history.state_space import StateSpace

MEANING = {
    "A": "states to states",
    "B": "damper forces to states",
    "E": "ground acceleration to states",
    "C": "states to accelerations",
    "D": "damper forces to accelerations",
    "connection": "Λ",
    "F": "ground acceleration to accelerations",
}


@describe.register
def describe_state_space(system: StateSpace) -> Description:
    """The matrices, their shapes and what they mean."""
    shapes = {name: " × ".join(map(str, getattr(system, name).shape)) for name in MEANING}
    floors, dampers = system.connection.shape
    return Description(
        f"StateSpace of {floors} floors and {counted(dampers, 'damper')}, SI",
        [(name, f"{shapes[name]}, {words}") for name, words in MEANING.items()],
    )
