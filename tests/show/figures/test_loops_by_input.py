"""Loops of several records beside one another, with one scale of force."""

import numpy as np
from tests.show.figures.figure_examples import F, X

from dampyr.origin import Origin
from dampyr.show.figures.loops_by_input import RecordLoop, loops_by_input


def test_a_panel_holds_its_own_record_in_mm_and_n() -> None:
    records = {"0 V": RecordLoop(X, F, {"fit": 0.9 * F}), "1.98 V": RecordLoop(2.0 * X, 3.0 * F, {"fit": 2.5 * F})}
    fig = loops_by_input(records, Origin("measured"))
    for panel, (name, loop) in zip(fig.axes, records.items(), strict=True):
        measured, modelled = panel.lines
        assert panel.get_title(loc="left") == name
        np.testing.assert_allclose(measured.get_xydata(), np.column_stack((1e3 * loop.displacement, loop.measured)))
        np.testing.assert_allclose(
            modelled.get_xydata(), np.column_stack((1e3 * loop.displacement, loop.models["fit"]))
        )
        assert [line.get_label() for line in panel.lines] == ["measured", "fit"]
    assert fig.axes[0].get_ylim() == fig.axes[1].get_ylim()
    assert fig.get_supxlabel() == "displacement [mm]"
    assert [panel.get_ylabel() for panel in fig.axes] == ["force [N]", ""]
