"""What the drive of a test shows: its set points, their extents, and what is recorded of them."""

from dataclasses import replace

import numpy as np

from dampyr.rig import Drive
from dampyr.show.descriptions import description_of

DRIVE = Drive(
    0.005, 0.01 * np.sin(np.linspace(0.0, 2 * np.pi, 401)), np.full(401, 1.98), record_from=100, record_to=301
)


def test_extents_are_in_mm_and_v_and_the_record_begins_and_ends_with_its_set_points() -> None:
    rows = dict(description_of(DRIVE).rows)
    assert rows["set points"].startswith("401, every 5 ms, ")
    assert rows["displacement"] == "-10 … 10 mm"
    assert rows["voltage"] == "1.98 V"
    assert rows["recorded"] == "0.5 … 1.5 s"  # set points 100 to 300
    assert {"reversals", "until"}.isdisjoint(rows)


def test_without_an_end_it_is_recorded_to_the_last_set_point() -> None:
    rows = dict(description_of(replace(DRIVE, record_to=None, until_temperature=40.0)).rows)
    assert rows["recorded"] == "0.5 … 2 s"
    assert rows["until"] == "40 °C"


def test_the_frame_is_in_si_units() -> None:
    frame = DRIVE.to_dataframe()
    np.testing.assert_array_equal(frame["displacement_m"], DRIVE.displacement)
    np.testing.assert_allclose(frame["time_s"], 0.005 * np.arange(401))
    np.testing.assert_array_equal(frame["voltage_V"], 1.98)
