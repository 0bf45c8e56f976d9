"""What a hybrid test shows: its peaks beside the computed ones, how well the table followed, and what the energy lost."""

import numpy as np
import pytest
from matplotlib import pyplot

from dampyr import structures, studies
from dampyr.ground_motions import GroundMotion
from dampyr.hybrid.hybrid_result import HybridResult
from dampyr.origin import Origin
from dampyr.show.descriptions import description_of
from dampyr.show.hybrid.hybrid_result import outcome, peaks_table
from dampyr.structures import Response


@pytest.fixture(scope="module")
def result() -> HybridResult:
    """The computed response with 2 % more on the first floor, 10 % less on the second, and a stroke that is 3 % too small."""
    t = np.arange(0.0, 2.0, 0.02)
    motion = GroundMotion(2.0 * np.sin(2 * np.pi * 2.0 * t) * np.exp(-t), 0.02)
    computed = structures.respond(structures.two_storey(), motion, studies.raminelli_2020.damper(), voltage=1.98)
    assert isinstance(computed, Response)
    scaled = computed.displacement / np.abs(computed.displacement).max(axis=1)[:, None]
    floors = scaled * (np.array([1.02, 0.9]) * computed.peak_displacement)[:, None]
    stroke, force = computed.stroke[0], computed.force[0]
    return HybridResult(
        "a sine", 0.5, 20.0, 1.98, computed.time, floors, stroke, 0.97 * stroke, force, 0.9 * force, 12.0, 0.0015, 1.0,
        -0.0125, computed, Origin("measured"),
    )  # fmt: skip


def test_a_row_holds_both_peaks_in_mm_and_by_how_much_they_differ(result: HybridResult) -> None:
    table, peaks = peaks_table(result), 1e3 * result.computed.peak_displacement
    assert table.heads == ["floor", "hybrid test [mm]", "computed [mm]", "difference [%]"]
    for row, factor, computed in zip(table.rows, (1.02, 0.9), peaks, strict=True):
        assert list(row[1:]) == pytest.approx([factor * computed, computed, 100 * (factor - 1.0)])


def test_the_sentences_name_the_worst_floor_and_the_share_that_was_not_followed(result: HybridResult) -> None:
    peaks, followed = outcome(result)
    assert "by up to -10 % (floor 2)" in peaks
    assert "The table followed what the building wanted to 3 % rms, 1.5 ms late" in followed
    assert "-1.2 % of the ground's energy" in followed


def test_the_text_is_in_the_units_that_people_read(result: HybridResult) -> None:
    rows = dict(description_of(result).rows)
    assert rows["ground motion"] == f"scaled to 0.5, {result.time[-1]:.4g} s on a clock 20 times slower"
    assert rows["damper"] == f"1.98 V, {np.abs(result.force).max():.4g} N at most"
    assert rows["tracking"] == "3 % rms, 1.5 ms late"
    assert rows["peaks"].count("%") == 2


def test_json_frame_and_figure_hold_the_histories(result: HybridResult) -> None:
    data, frame = result.as_dict(), result.to_dataframe()
    assert data["differences"] == pytest.approx([0.02, -0.1])
    assert data["tracking_error"] == pytest.approx(0.03)
    np.testing.assert_array_equal(frame["floor_2_m"], result.displacement[1])
    np.testing.assert_array_equal(frame["achieved_m"], result.achieved)
    [panel] = result.plot()
    drawn = {str(line.get_label()).partition(":")[0]: line.get_ydata() for line in panel.lines}
    np.testing.assert_allclose(drawn["hybrid test"], 1e3 * result.displacement[1])
    pyplot.close("all")
