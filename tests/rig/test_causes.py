"""What stopped the table is told by its cause: a scale that slipped, and play in the screw, are no motor that is too fast."""

from __future__ import annotations

from dataclasses import replace

import pytest

import dampyr as dp
from dampyr.errors import RigFault
from dampyr.rig import RigSettings
from dampyr.rig.acquisition import fault_in_words
from dampyr.rig.firmware.protocol import Fault


def test_a_table_that_is_too_fast_while_it_is_not_homed_has_a_sentence_of_its_own() -> None:
    assert fault_in_words(Fault.SPEED) == "the table was too fast"
    words = fault_in_words(Fault.SPEED | Fault.HEARTBEAT, slow=True)
    assert "is there play in the screw" in words
    assert words.startswith("the host was silent")


def reason(rig: RigSettings, places: tuple[float, ...], faults: tuple[str, ...] = ()) -> str:
    """Why a table that is homed and sent to these places was stopped."""

    def move() -> None:
        with dp.rig.simulated(rig, faults=faults) as simulated, simulated.armed() as table:
            table.home()
            for place in places:
                table.go(place)

    with pytest.raises(RigFault) as raised:
        move()
    return str(raised.value)


@pytest.mark.parametrize("at", ["2s", "8s"])  # while the index is looked for, and while set points are followed
def test_a_scale_that_slips_by_5_mm_is_told_as_the_encoder(at: str) -> None:
    words = reason(RigSettings(), (0.02, -0.02), (f"slipped-encoder=5mm@{at}",))
    assert "its count leapt farther than any motor moves" in words
    assert "too fast" not in words


def test_play_of_a_millimetre_is_told_as_play() -> None:
    rig = RigSettings()
    loose = replace(rig, actuator=replace(rig.actuator, backlash=1e-3))
    assert "is there play in the screw or its mounts" in reason(loose, (0.002,))
