"""Ground motions in MATLAB's files."""

import numpy as np
import pytest
from scipy.io import savemat

from dampyr.errors import FileError
from dampyr.ground_motions import el_centro, read

G = 9.80665


def text(folder, content, name="motion.txt"):
    path = folder / name
    path.write_text(content)
    return path


def test_the_mat_file_is_the_same_without_the_zero(ground_motion_folder):
    motion = read(ground_motion_folder / "ElCentroData.mat", units="g")
    assert motion.n == 1560
    assert motion.dt == 0.02
    assert motion.acceleration[:1559] == pytest.approx(el_centro().acceleration[1:], rel=1e-12, abs=1e-15)


def test_mat_files_without_a_table_are_refused(tmp_path):
    savemat(tmp_path / "a.mat", {"x": np.zeros((5, 3))})
    with pytest.raises(FileError, match="holds x; it must hold one matrix"):
        read(tmp_path / "a.mat", units="g")
    savemat(tmp_path / "b.mat", {"x": np.column_stack([np.arange(5) * 0.02, np.ones(5)])})
    assert read(tmp_path / "b.mat", units="g").pga == pytest.approx(G)
    with pytest.raises(FileError, match="units='g'"):
        read(tmp_path / "b.mat")
    with pytest.raises(FileError, match="not a MATLAB file"):
        read(
            text(tmp_path, "no matlab at all, and long enough to be taken for a header" * 5, "c.mat"),
            units="g",
        )
