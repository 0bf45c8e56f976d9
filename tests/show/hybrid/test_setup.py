"""What the set-up of a virtual hybrid test shows."""

from dampyr.hybrid.setup import HybridSetup, PhysicalSubstructure
from dampyr.show.descriptions import description_of
from dampyr.structures import two_storey


def test_place_specimen_actuator_and_loop_have_their_units() -> None:
    specimen = PhysicalSubstructure(mass=4.0, stiffness=2500.0, damping_ratio=0.05)
    setup = HybridSetup(two_storey(), specimen, rate=2048.0, force_delay=2)
    rows = dict(description_of(setup).rows)
    assert rows["specimen"] == "4 kg, 2500 N/m, 10 N s/m"  # 2 ζ √(k m)
    assert rows["loop"] == "2048 Hz, the force 2 samples late"
    transfer = setup.transfer
    assert f"at most {transfer.max_force:g} N" in rows["actuator"]
    assert f"a3 {transfer.pole:g} 1/s" in rows["actuator"]
    assert rows["place"] == setup.structure.place_label(1)
