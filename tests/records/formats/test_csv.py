"""Records as text with units in the header: every bit, and an input that varies."""

import numpy as np

from dampyr.records import read, write


def test_a_csv_keeps_every_bit_and_a_varying_input(tmp_path, make_sine):
    record = make_sine()
    record = record.replace(note="a varying input", current=np.linspace(0.1, 0.7, record.n), voltage=None)
    back = read(write(record, tmp_path / "a.csv"))
    assert np.array_equal(back.force, record.force)
    assert np.array_equal(back.current, record.current)
