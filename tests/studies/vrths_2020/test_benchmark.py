"""Silva et al. (2020), MSSP 135, 106381: the buildings and motions of the benchmark."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from dampyr.errors import FileError, InputError, MissingData
from dampyr.ground_motions import GroundMotion
from dampyr.hybrid import PhaseLeadCompensator, perform_virtual
from dampyr.studies import vrths_2020
from dampyr.studies.vrths_2020.vrths_study import set_up


class TestTheBuildings:
    def test_they_are_read_from_their_files(self) -> None:
        first = vrths_2020.structure(1)
        np.testing.assert_allclose(first.frequencies, [3.612, 15.997, 38.086], atol=6e-4)
        ratios = [vrths_2020.structure(case).damping_ratios for case in vrths_2020.CASES]
        np.testing.assert_allclose(ratios, np.outer([0.05, 0.04, 0.03, 0.03], np.ones(3)), rtol=1e-9)
        masses = [vrths_2020.structure(case).M[0, 0] for case in vrths_2020.CASES]
        assert masses == [1000.0, 1100.0, 1300.0, 1000.0]

    def test_another_case_is_refused(self) -> None:
        with pytest.raises(InputError, match="case 5 is not one of the benchmark's"):
            vrths_2020.structure(5)

    @pytest.mark.prove
    def test_the_peaks_of_the_reference(self, el_centro: GroundMotion) -> None:
        run = perform_virtual(set_up(1), PhaseLeadCompensator(), el_centro)
        np.testing.assert_allclose(1e3 * np.abs(run.reference).max(axis=1), [3.902, 6.309, 7.768], atol=6e-4)


class TestTheMotions:
    def test_they_are_the_benchmarks(self, motions: Path) -> None:
        first, kobe = (vrths_2020.motion(name, motions, 1.0) for name in ("El Centro", "Kobe"))
        assert (first.n, first.dt) == (2060, pytest.approx(0.02))
        assert (kobe.n, kobe.dt) == (5095, pytest.approx(0.01))
        assert (first.pga, kobe.pga) == (pytest.approx(3.1349, abs=1e-4), pytest.approx(6.3298, abs=1e-4))

    def test_absent_or_wrong_files_are_said(self, tmp_path: Path) -> None:
        with pytest.raises(MissingData, match=r"ElCentroAccelNoScaling.mat is not in .*get it from https://github.com"):
            vrths_2020.motion("El Centro", tmp_path)
        (tmp_path / "ElCentroAccelNoScaling.mat").write_bytes(b"no MATLAB file" * 20)
        with pytest.raises(FileError, match="has no motion ElCentroAccel"):
            vrths_2020.motion("El Centro", tmp_path)
        with pytest.raises(InputError, match="'Morgan' is not a motion"):
            vrths_2020.motion("Morgan", tmp_path)


def test_a_file_that_was_cut_is_refused(motions: Path, tmp_path: Path) -> None:
    name = "ElCentroAccelNoScaling.mat"
    shutil.copy(motions / name, tmp_path / name)
    (tmp_path / name).write_bytes((tmp_path / name).read_bytes()[:200])
    with pytest.raises(FileError, match="has no motion ElCentroAccel"):
        vrths_2020.motion("El Centro", tmp_path)
