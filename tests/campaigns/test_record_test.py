"""What a record of a campaign says of itself: its session and its specimen."""

from dataclasses import replace
from datetime import datetime
from pathlib import Path

import numpy as np
import pytest
from tests.campaigns.quick_rig import QUICK, SHORT, TWO, quick_rig

from dampyr import campaigns, records
from dampyr.campaigns import perform
from dampyr.campaigns.record_test import groups_of, refined
from dampyr.records.cycle_analysis.device_figures import SteadyCycles, device_figures
from dampyr.records.formats import h5
from dampyr.rig import RigSettings


def test_a_record_says_its_session_and_its_specimen(two: Path, tmp_path: Path) -> None:
    """Where nothing is said: the day of the run, and the data sheet; what is said goes before it."""
    days = {datetime.now().astimezone().date().isoformat()}
    first, second = perform(two, quick_rig(), tmp_path / "a")
    days.add(datetime.now().astimezone().date().isoformat())  # the run may have begun before midnight
    assert first.specimen == second.specimen == "RD-8041-1"
    assert first.measurement_session == second.measurement_session
    assert first.measurement_session in {f"{day} RD-8041-1" for day in days}
    two.write_text('measurement_session = " third mounting "\nspecimen = "no. 7"\n' + TWO, encoding="utf-8")
    for record in perform(two, quick_rig(), tmp_path / "b"):
        assert (record.measurement_session, record.specimen) == ("third mounting", "no. 7")


def test_a_record_says_where_its_steady_cycles_are_and_they_have_the_full_amplitude(two_sines: Path) -> None:
    """The run-in of the sine of 1 Hz ends 1.2 s after the begin; its cycle is no partial one."""
    for record in records.read_campaign(two_sines / "out"):
        steady = SteadyCycles.of(record)
        assert steady == SteadyCycles(pytest.approx(record.time[0] + 1.2), 1.0, 1)
        [cycle] = device_figures(record)
        assert cycle.amplitude == pytest.approx(0.5 * np.ptp(record.displacement), rel=0.01)


@pytest.mark.parametrize(
    ("specimen", "stated", "expected"),
    [
        ({}, {}, ("2026-03-01 RD-8041-1", "RD-8041-1")),
        ({"card": "cards/number_7.toml"}, {}, ("2026-03-01 number_7", "number_7")),
        ({"card": "number_7.toml", "name": "no. 7"}, {}, ("2026-03-01 no. 7", "no. 7")),
        ({"name": "no. 7"}, {"specimen": "no. 8"}, ("2026-03-01 no. 8", "no. 8")),
        ({"data_sheet": ""}, {}, ("2026-03-01", None)),
        ({"name": "no. 7"}, {"measurement_session": "day 1"}, ("day 1", "no. 7")),
    ],
)
def test_what_the_campaign_states_goes_before_what_the_rig_does(
    two: Path, specimen: dict[str, str], stated: dict[str, str], expected: tuple[str, str | None]
) -> None:
    settings = replace(RigSettings(), specimen=replace(RigSettings().specimen, **specimen))
    campaign = campaigns.read(two)
    campaign = replace(campaign, header=replace(campaign.header, **stated))
    groups = groups_of(settings, campaign, datetime(2026, 3, 1, 23, 59).astimezone())
    assert (groups["measurement_session"], groups.get("specimen")) == expected


def test_the_inertia_of_a_mass_on_a_sine_is_taken_off_with_its_sign() -> None:
    """A mass m on x = A sin(w t) needs m a = -m A w^2 sin(w t): what is left of it is nothing."""
    mass, amplitude, w = 12.0, 0.01, 2.0 * np.pi * 2.0
    rig = replace(
        RigSettings(), load_cell=replace(RigSettings().load_cell, mass=mass, bandwidth=1e6)
    )  # without a delay
    t = np.arange(4000) / rig.board.rate
    spring = 5000.0 * amplitude * np.sin(w * t)
    cell = spring - mass * amplitude * w**2 * np.sin(w * t)
    left = refined({"time": t, "displacement": amplitude * np.sin(w * t), "force": cell}, rig)["force"]
    inside = slice(100, -100)
    assert np.abs(left - spring)[inside].max() < 1e-3 * mass * amplitude * w**2
    untouched = replace(rig, load_cell=replace(rig.load_cell, mass=0.0))
    values = {"time": t, "displacement": amplitude * np.sin(w * t), "force": cell}
    assert refined(values, untouched)["force"] is cell


def test_the_simulated_cell_feels_the_mass_and_its_record_does_not(two: Path, tmp_path: Path) -> None:
    """Of two rigs that differ by 20 kg at the cell the raw forces differ by m a, and those of the records do not."""
    two.write_text(SHORT.format(voltage='"0 V"').replace('"1 Hz"', '"2 Hz"'), encoding="utf-8")
    mass, rows = 20.0, slice(1000, 2500)
    found = {}
    for kg in (0.0, mass):
        settings = replace(QUICK, load_cell=replace(QUICK.load_cell, mass=kg))
        (record,) = perform(two, quick_rig(settings=settings), tmp_path / f"{kg:g}")
        raw = h5.read_raw(next((tmp_path / f"{kg:g}").glob("*.h5")))["force"]
        found[kg] = record, (raw.gain * raw.values + raw.offset)[rows]
    (plain, light), (record, heavy) = found[0.0], found[mass]
    x = record.displacement[rows] - np.mean(record.displacement[rows])
    inertia = -mass * (4.0 * np.pi) ** 2 * x
    share = float(np.dot(heavy - light, inertia) / np.dot(inertia, inertia))
    assert share == pytest.approx(1.0, abs=0.1)
    left = record.force[rows] - plain.force[rows]
    assert abs(float(np.dot(left, inertia) / np.dot(inertia, inertia))) < 0.1
    assert any("20 kg hang at the load cell" in line for line in record.history)
    assert "inertia" in record.uncertainty["force"].parts
    assert "inertia" not in plain.uncertainty["force"].parts
