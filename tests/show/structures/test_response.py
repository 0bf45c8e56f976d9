"""What the response of a building shows: the peaks of its histories, in the units that people read."""

import numpy as np
import pytest
from matplotlib import pyplot

from dampyr import structures, studies
from dampyr.errors import InputError
from dampyr.ground_motions import GroundMotion
from dampyr.show.descriptions import description_of
from dampyr.show.structures.response import floor_rows
from dampyr.structures import Response

BETWEEN = 0.02  # of a peak: it is sought between the samples, too


@pytest.fixture(scope="module")
def response() -> Response:
    t = np.arange(0.0, 2.0, 0.02)
    motion = GroundMotion(2.0 * np.sin(2 * np.pi * 2.0 * t) * np.exp(-t), 0.02)
    answer = structures.respond(structures.two_storey(), motion, studies.raminelli_2020.damper(), voltage=1.98)
    assert isinstance(answer, Response)
    return answer


def test_a_row_of_a_floor_holds_the_peaks_of_its_histories(response: Response) -> None:
    below = np.vstack((np.zeros(len(response.time)), response.displacement[:-1]))
    drift = np.abs(response.displacement - below).max(axis=1)
    rows = floor_rows(response)
    assert [row[0] for row in rows] == list(response.floors)
    np.testing.assert_allclose([row[1] for row in rows], 1e3 * np.abs(response.displacement).max(axis=1), rtol=BETWEEN)
    np.testing.assert_allclose([row[2] for row in rows], 1e3 * drift, rtol=BETWEEN)
    np.testing.assert_allclose([row[3] for row in rows], np.abs(response.acceleration).max(axis=1), rtol=BETWEEN)


def test_json_and_frame_hold_si_units(response: Response) -> None:
    data, frame = response.as_dict(), response.to_dataframe()
    np.testing.assert_array_equal(data["peak_drift_m"], response.peak_drift)
    np.testing.assert_array_equal(frame["peak_displacement_m"], response.peak_displacement)
    assert list(frame.index) == list(response.floors)
    assert data["step_s"] == response.step


def test_its_text_has_the_damper_and_its_force(response: Response) -> None:
    rows = dict(description_of(response).rows)
    assert rows["damper"].endswith(", 1.98 V")
    assert float(rows["damper force"].split()[1]) == pytest.approx(np.abs(response.force).max(), rel=BETWEEN)


def test_plots_show_the_histories_and_the_energies_that_add_up(response: Response) -> None:
    [drift] = response.plot.history("drift")
    names = [str(line.get_label()).partition(":")[0] for line in drift.lines if ":" in str(line.get_label())]
    assert names == ["storey 1", "storey 2"]
    [energy] = response.plot.energy()
    tops = energy.collections[-1].get_paths()[0].get_extents().y1
    e = response.energy
    assert tops == pytest.approx(np.max(e.damper + e.viscous + e.strain + e.kinetic), rel=1e-6)
    pyplot.close("all")
    with pytest.raises(InputError, match="no history of 'speed'; choose from displacement"):
        response.plot.history("speed")
