"""What the settings of a rig show, in the units that people read."""

from dataclasses import replace

from dampyr.rig import RigSettings
from dampyr.show.descriptions import description_of
from dampyr.show.rig.settings import limits_of_motion

RIG = RigSettings()


def test_limits_are_in_mm_and_n() -> None:
    limits = replace(RIG.limits, stroke=0.0625, speed=0.2, force=1800.0)
    assert limits_of_motion(limits) == "62.5 mm peak to peak, 200 mm/s, 1800 N"


def test_every_part_of_the_rig_has_its_row() -> None:
    settings = replace(
        RIG,
        board=replace(RIG.board, rate=1000.0, block=0.05),
        encoder=replace(RIG.encoder, count=2.5e-6),
        actuator=replace(RIG.actuator, free_speed=0.25, max_load=5000.0),
    )
    rows = dict(description_of(settings).rows)
    assert rows["board"] == "1000 Hz in blocks of 50 ms"
    assert rows["encoder"] == "2.5 µm a count"
    assert rows["actuator"] == "250 mm/s free, 5000 N"
    assert rows["limits"] == limits_of_motion(settings.limits)


def test_a_rig_without_wires_can_only_be_simulated() -> None:
    assert dict(description_of(replace(RIG, wires=replace(RIG.wires, serial=""))).rows)["wires"].startswith("none")
    assert (
        dict(description_of(replace(RIG, wires=replace(RIG.wires, serial="/dev/ttyUSB0"))).rows)["wires"]
        == "/dev/ttyUSB0"
    )
