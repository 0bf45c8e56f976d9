"""What a building by modes shows."""

from __future__ import annotations

from dataclasses import replace

from dampyr.show.descriptions import Description, describe
from dampyr.show.structures.building import describe_building
from dampyr.structures.time_history.modal_coordinates import ModalBuilding


@describe.register
def describe_modal_building(building: ModalBuilding) -> Description:
    """What a building shows, and the modes that were kept."""
    base = describe_building(building)
    modes = f"{len(building.retained_modes)} of {len(building.squares)}"
    return replace(
        base, rows=[*base.rows, ("modes kept", f"{modes}, with {100 * building.mass_share:.4g} % of the mass")]
    )
