"""The plastic-region method: a clean loop, what it refuses, and the published friction."""

import numpy as np
import pytest
from tests.identification.synthetic import DAHL, sine

from dampyr.errors import InputError
from dampyr.identification import plastic_region
from dampyr.models import Damper
from dampyr.models.parts import Dahl
from dampyr.records import Record
from dampyr.records.files.campaign_folder import campaign_rows


def test_the_numbers_of_a_clean_loop_come_back() -> None:
    """An offset, a dashpot and friction whose slope where it crosses zero is kw rho (1 - w**2 is 1 there)."""
    found = plastic_region(sine(DAHL, 0.0, offset=120.0, seconds=10.0))
    assert (found.kx, found.kw, found.offset) == pytest.approx((900.0, 70.0, 120.0), rel=0.03)
    assert found.rho == pytest.approx(found.a / found.kw, rel=1e-12)
    assert found.rho == pytest.approx(2500.0, rel=0.15)
    assert found.rho_spread < 0.02 * found.rho
    assert 8 <= found.turning_points <= 19
    assert 0.3 < found.share < 0.7
    assert found.model == Dahl(found.kx, found.kw, found.rho)


def test_dry_friction_and_a_dashpot_are_read_off_the_fast_samples() -> None:
    """Friction that turns at once: its force at speed is offset + kx v + kw sign(v), by least squares."""
    record = sine(DAHL, 0.0, seconds=10.0)
    v = record.velocity
    assert v is not None
    dry = record.replace(note="dry", force=33.0 + 1400.0 * v + 210.0 * np.tanh(v / 1e-3))
    found = plastic_region(dry)
    assert (found.offset, found.kx, found.kw) == pytest.approx((33.0, 1400.0, 210.0), rel=1e-3)


def test_what_has_no_plastic_region_says_why() -> None:
    record = sine(DAHL, 0.0, seconds=10.0)
    with pytest.raises(InputError, match="no whole cycle"):
        plastic_region(record.until(0.6))
    with pytest.raises(InputError, match=r"dry friction comes out as -.* N; is the force's sign inverted\?"):
        plastic_region(record.replace(note="turned", force=-record.force))
    springy = Damper("dahl", {"dahl.kx": 900.0, "dahl.kw": 70.0, "dahl.rho": 30.0})
    with pytest.raises(InputError, match=r"only \d samples are in the plastic region; the stroke is too small"):
        plastic_region(sine(springy, 0.0, amplitude=0.002, seconds=10.0))


@pytest.fixture(scope="module")
def records(published_fit_records: list[Record]) -> list[Record]:
    return published_fit_records


@pytest.mark.prove
def test_the_plastic_region_gives_the_published_friction_without_a_window(records) -> None:
    published = {row.file.stem: row.published for row in campaign_rows() if row.file} or {
        row.file_name.removesuffix(".mat"): row.published for row in campaign_rows() if row.file_name
    }
    ours = {r.name: plastic_region(r) for r in records}
    for voltage, tolerance in ((0.0, 0.15), (0.8712, 0.05), (1.98, 0.07), (3.212, 0.04)):
        group = [r.name for r in records if r.voltage == pytest.approx(voltage)]
        mean = np.mean([ours[name].kw for name in group])
        assert mean == pytest.approx(np.mean([published[name]["kw"] for name in group]), rel=tolerance)
