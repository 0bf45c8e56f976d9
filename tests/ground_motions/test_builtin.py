"""El Centro, the motion that comes with the package, against the published files."""

import numpy as np
import pytest

from dampyr.ground_motions import el_centro

G = 9.80665


def test_el_centro_is_the_peknold_record_with_a_zero_in_front():
    motion = el_centro()
    assert motion.n == 1560
    assert motion.dt == 0.02
    assert motion.duration == pytest.approx(31.18)
    assert motion.pga == pytest.approx(0.31882 * G, rel=1e-12)
    assert motion.acceleration[:3] == pytest.approx([0.0, 0.0063 * G, 0.00364 * G], rel=1e-12)
    assert motion.acceleration[-1] == 0.0
    assert motion.time[-1] == pytest.approx(31.18)


def test_el_centro_agrees_with_the_file_of_the_data_folder(ground_motion_folder):
    lines = (ground_motion_folder / "el_centro_1940_ns_peknold.dat").read_text().splitlines()
    rows = [line for line in lines if line.strip() and not line.startswith("#")]
    words = [row[i : i + 10] for row in rows for i in range(0, len(row), 10)]
    values = np.array([float(word) for word in words if word.strip()])
    assert np.array_equal(el_centro().acceleration[1:], values[:1559] * G)
