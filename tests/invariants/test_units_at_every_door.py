"""A quantity or a labelled array is converted or refused at every door of Python, and a path in mm is asked about."""

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pint
import pytest
import xarray as xr

import dampyr as dp
from dampyr.errors import DampyrWarning, InputError, RangeError
from dampyr.units import in_si

UNITS = pint.UnitRegistry()
T = np.linspace(0.0, 4.0, 801)
X = 8e-3 * np.sin(2 * np.pi * 0.9 * T)
BUILDING, MOTION = dp.structures.two_storey(), dp.ground_motions.el_centro()


def damper() -> Any:
    return dp.studies.raminelli_2020.damper()


def calibrated() -> Any:
    ranges = {"displacement": (0.0, 0.012), "velocity": (0.0, 0.07)}
    return dp.models.Damper("dahl", {"dahl.kx": 1000.0, "dahl.kw": 200.0, "dahl.rho": 1000.0}, ranges=ranges)


WAYS = {
    "pint": lambda values, unit: UNITS.Quantity(values, unit),
    "a list of pint": lambda values, unit: [UNITS.Quantity(each, unit) for each in np.atleast_1d(values)],
    "xarray units": lambda values, unit: xr.DataArray(values, attrs={"units": unit}),
    "xarray unit": lambda values, unit: xr.DataArray(values, attrs={"unit": unit}),
    "pint in xarray": lambda values, unit: xr.DataArray(UNITS.Quantity(values, unit)),
}


@pytest.mark.parametrize("way", WAYS)
def test_the_force_along_a_path_in_mm_is_that_of_the_path_in_m(way: str) -> None:
    given, plain = WAYS[way], damper().force(T, X, voltage=1.98)
    force = damper().force(given(1e3 * T, "ms"), given(1e3 * X, "mm"), voltage=UNITS.Quantity(1980.0, "mV"))
    np.testing.assert_allclose(force, plain, rtol=0, atol=1e-9 * plain.max())
    v = np.gradient(X, T)
    by_velocity = damper().force(T, X, voltage=given(np.full(T.size, 1980.0), "mV"), velocity=given(100.0 * v, "cm/s"))
    np.testing.assert_allclose(by_velocity, damper().force(T, X, voltage=1.98, velocity=v), rtol=1e-9)


@pytest.mark.parametrize("way", WAYS)
def test_a_record_of_quantities_is_in_si(way: str) -> None:
    given, force = WAYS[way], damper().force(T, X, voltage=1.98)
    plain = dp.records.Record(T, X, force, voltage=1.98, temperature=np.full(T.size, 20.0))
    warm = UNITS.Quantity(np.full(T.size, 293.15), "kelvin")
    record = dp.records.Record(
        given(1e3 * T, "ms"), given(1e3 * X, "mm"), given(force / 1e3, "kN"), voltage="1980 mV", temperature=warm
    )
    for name in ("time", "displacement", "force", "temperature"):
        np.testing.assert_allclose(getattr(record, name), getattr(plain, name), rtol=1e-12, atol=1e-12, err_msg=name)
    assert record.voltage == pytest.approx(1.98)


def test_a_motion_and_a_building_take_quantities() -> None:
    motion = dp.ground_motions.GroundMotion(UNITS.Quantity(MOTION.acceleration * 100.0, "cm/s**2"), "20 ms", "in gal")
    np.testing.assert_allclose(motion.acceleration, MOTION.acceleration, rtol=1e-12)
    assert motion.dt == 0.02
    assert motion.scaled_to_pga(UNITS.Quantity(0.3, "standard_gravity")).pga == pytest.approx(0.3 * 9.80665)
    assert motion.scaled(UNITS.Quantity(50.0, "percent")).pga == pytest.approx(0.5 * motion.pga)
    plain = dp.structures.respond(BUILDING, MOTION, damper(), voltage=1.98).peak_displacement
    for voltage in (UNITS.Quantity(1980.0, "mV"), "1.98 V", xr.DataArray(1980.0, attrs={"units": "mV"})):
        response = dp.structures.respond(BUILDING, MOTION, damper(), voltage=voltage)
        np.testing.assert_allclose(response.peak_displacement, plain, rtol=1e-12)
    peaks = dp.structures.ensemble(
        BUILDING,
        MOTION,
        damper(),
        voltage=UNITS.Quantity([0.0, 1980.0], "mV"),
        scales=UNITS.Quantity(100.0, "percent"),
    ).dataset
    np.testing.assert_allclose(peaks.input.values, [0.0, 1.98])
    np.testing.assert_allclose(peaks.scale.values, [1.0])


def test_the_parameters_of_a_damper_take_quantities() -> None:
    numbers = {"dahl.kx": UNITS.Quantity(1.0, "N*s/mm"), "dahl.kw": "0.2 kN", "dahl.rho": UNITS.Quantity(1.0, "1/mm")}
    assert dp.models.Damper("dahl", numbers).at(0.0) == calibrated().at(0.0)


WRONG: dict[str, Any] = {
    "force of a path in N": lambda: damper().force(T, UNITS.Quantity(X, "N"), voltage=1.98),
    "force at a current": lambda: damper().force(T, X, voltage=UNITS.Quantity(1.0, "A")),
    "record in kg": lambda: dp.records.Record(T, UNITS.Quantity(X, "kg"), X, voltage=0.0),
    "record with an unknown unit": lambda: dp.records.Record(T, xr.DataArray(X, attrs={"units": "spans"}), X),
    "motion in m": lambda: dp.ground_motions.GroundMotion(UNITS.Quantity(X, "m"), 0.01),
    "voltage of a building in A": lambda: dp.structures.respond(BUILDING, MOTION, damper(), voltage=UNITS.Quantity(1, "A")),
    "voltages of an ensemble in A": lambda: dp.structures.ensemble(BUILDING, MOTION, damper(), UNITS.Quantity([1.0], "A")),
    "scales in m": lambda: dp.structures.ensemble(BUILDING, MOTION, damper(), 1.0, scales=UNITS.Quantity([1.0], "m")),
    "a parameter in m": lambda: dp.models.Damper("dahl", {"dahl.kx": 1.0, "dahl.kw": UNITS.Quantity(1, "m"), "dahl.rho": 1.0}),
}  # fmt: skip


@pytest.mark.parametrize("what", WRONG)
def test_a_unit_that_measures_something_else_is_refused(what: str) -> None:
    with pytest.raises(InputError, match="unit"):
        WRONG[what]()


def test_a_series_without_a_unit_is_si() -> None:
    assert np.array_equal(damper().force(T, pd.Series(X), voltage=1.98), damper().force(T, X, voltage=1.98))
    assert in_si(3.0, "m", "x") == 3.0


@pytest.mark.parametrize("which", [damper, calibrated])
def test_a_path_in_mm_is_asked_about(which: Any) -> None:
    """Wherever a person gives it: the force, a score, a validation. By name it is taken, with the usual warning."""
    with pytest.raises(RangeError, match="is the path in mm"):
        which().force(T, 1e3 * X, voltage=1.98)
    record = dp.records.Record(T, 1e3 * X, X, voltage=1.98, name="in mm")
    for call in (
        lambda: dp.identification.score(which(), record),
        lambda: dp.identification.validate(which(), [record]),
    ):
        with pytest.raises(RangeError, match="is the path in mm"):
            call()
    assert any("is its unit right" in note for note in dp.records.quality(record).notes)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)
        assert which().force(T, 1e3 * X, voltage=1.98, allow_extrapolation=True).max() > 1e4


def test_up_to_20_times_the_calibrated_path_is_a_warning() -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        calibrated().force(T, 10.0 * X)
    assert sorted(str(each.message).partition(";")[0] for each in caught) == [
        "displacement reaches 0.08 m", "velocity reaches 0.4523 m/s",
    ]  # fmt: skip


def test_a_building_that_moves_far_is_a_note_with_the_share_of_cases(tmp_path: Path) -> None:
    near = dp.models.Damper(
        "dahl", {"dahl.kx": 1000.0, "dahl.kw": 20.0, "dahl.rho": 1000.0}, ranges={"displacement": (0.0, 1e-3)}
    )
    with pytest.warns(DampyrWarning, match="calibrated up to 0.001 m"):
        response = dp.structures.respond(BUILDING, MOTION, near)
    assert response.doubts
    peaks = dp.structures.ensemble(BUILDING, MOTION, near, scales=[0.01, 0.5, 1.0]).dataset
    strokes = peaks.stroke.values.ravel()
    beyond = int(np.sum(strokes > 1.01e-3))
    assert 0 < beyond < 3
    assert peaks.attrs["outside"].startswith(
        f"in {beyond} of 3 cases ({100 * beyond / 3:.0f} %) a damper's stroke leaves the 1 mm"
    )
    assert f"by up to {strokes.max() / 1e-3:.1f} times" in peaks.attrs["outside"]
    dp.structures.ensemble(BUILDING, MOTION, near, scales=[0.01, 0.5, 1.0], out=tmp_path / "peaks.h5")
    assert dp.structures.read_ensemble(tmp_path / "peaks.h5").dataset.attrs["outside"] == peaks.attrs["outside"]


def test_a_motion_over_5_g_asks_about_its_unit() -> None:
    gal = 100.0 * MOTION.acceleration
    with pytest.warns(DampyrWarning, match=r"peaks at .* g; no earthquake is known above 5 g, so check the unit"):
        dp.ground_motions.GroundMotion(gal, 0.02)
    assert MOTION.scaled(30.0).pga > 5 * 9.80665  # what is scaled was asked for


@pytest.mark.parametrize("name", dp.models.published.available_sets())
def test_a_published_set_states_what_its_source_moved(name: str) -> None:
    assert "no calibrated displacement or velocity is stated" in dp.models.published.damper(name).provenance["motion"]


def test_a_computed_motion_is_not_asked_about() -> None:
    """What a plan, a data sheet or a building moves was not typed: it warns only, also far beyond what was calibrated."""
    far = 100.0 * X
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DampyrWarning)
        computed = calibrated().force_of_motion(T, far)
        assert np.array_equal(computed, calibrated().force(T, far, allow_extrapolation=True))
    with pytest.warns(DampyrWarning, match="calibrated up to"):
        calibrated().force_of_motion(T, far)
