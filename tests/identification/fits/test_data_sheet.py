"""A fit that breaks the promises of the damper's data sheet (Table A.1) is flagged."""

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.identification import fit
from dampyr.identification.fits.data_sheet import contradictions, peak_to_peak
from dampyr.models import Constant, Damper, Interpolation
from dampyr.records import Record


def dahl(kx: float, kw: float, high: float = 4.4, unit: str = "V") -> Damper:
    laws = {name: Constant(value, 0.0, high) for name, value in (("dahl.kx", kx), ("dahl.kw", kw), ("dahl.rho", 5e3))}
    return Damper("dahl", laws, input=unit)


def test_the_force_of_a_sine_in_closed_form() -> None:
    """Long strokes: kx v + kw at the peak speed, peak to peak twice that."""
    assert peak_to_peak(dahl(1500.0, 300.0), 0.05, 1.0) == pytest.approx(2 * (1500 * 0.05 + 300), rel=1e-3)


def test_a_damper_that_is_too_weak_at_one_ampere_and_too_strong_at_none() -> None:
    weak, strong = contradictions(dahl(3000.0, 200.0))
    assert weak == (
        "at 5 cm/s and 1 A (4.4 V) the fit gives 700 N peak to peak, "
        "and the data sheet of the RD-8041-1 says more than 2447 N"
    )
    assert "at 20 cm/s and 0 A (0 V) the fit gives 1600 N peak to peak" in strong
    assert "says less than 667 N" in strong
    assert len(contradictions(dahl(3000.0, 200.0, 1.0, "A"))) == 2


def test_a_damper_that_keeps_both() -> None:
    laws = {
        "dahl.kx": Interpolation((0.0, 4.4), (500.0, 4000.0)),
        "dahl.kw": Interpolation((0.0, 4.4), (100.0, 1100.0)),
        "dahl.rho": Constant(5e3, 0.0, 4.4),
    }
    assert contradictions(Damper("dahl", laws)) == []


def test_nothing_is_extrapolated() -> None:
    assert contradictions(dahl(500.0, 100.0, high=3.2)) == []


def test_an_unknown_sheet_is_told() -> None:
    with pytest.raises(InputError, match=r"data sheet 'RD-9' is not known; .*RD-8041-1"):
        contradictions(dahl(500.0, 100.0), "RD-9")


@pytest.mark.parametrize("sheet", ["RD-8041-1", ""])
def test_a_fit_to_records_of_the_rig_is_flagged(sheet: str) -> None:
    t = np.arange(4000) * 1e-3
    x, v = 0.01 * np.sin(2 * np.pi * t), 0.01 * 2 * np.pi * np.cos(2 * np.pi * t)
    force = dahl(2000.0, 400.0).force(t, x, velocity=v, voltage=0.0)
    record = Record(t, x, force, velocity=v, voltage=0.0, provenance={"data_sheet": sheet})
    flagged = [note for note in map(str, fit([record], "dahl").findings) if "data sheet" in note]
    assert len(flagged) == (1 if sheet else 0)
