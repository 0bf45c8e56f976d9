"""The cubics (4.6) to (4.8) of Raminelli (2020), which come back at the applied voltages only."""

from dataclasses import replace

import pytest
from tests.studies.raminelli_2020.artefact_values import one

from dampyr.errors import ExtrapolationWarning, RangeError
from dampyr.studies import raminelli_2020
from dampyr.studies._compared_value import PrintedNumber
from dampyr.studies.raminelli_2020 import PUBLISHED
from dampyr.studies.raminelli_2020.cubics import equations


class TestDamper:
    def test_the_cubics_in_si(self) -> None:
        damper = raminelli_2020.damper()
        at_0, at_2 = damper.at(0.0), damper.at(2.0)
        assert (at_0.kx, at_0.kw, at_0.rho) == (802.0, 50.237, 42745.0)
        assert at_2.kx == pytest.approx(1e3 * (0.0855 * 8 + 0.0342 * 4 + 0.4931 * 2 + 0.802), rel=1e-12)
        assert at_2.kw == pytest.approx(3.6157 * 8 - 24.866 * 4 + 201.92 * 2 + 50.237, rel=1e-12)
        assert at_2.rho == pytest.approx(1e3 * (-2.8368 * 8 + 17.881 * 4 - 39.038 * 2 + 42.745), rel=1e-12)

    def test_it_knows_its_range_and_where_it_comes_from(self) -> None:
        damper = raminelli_2020.damper()
        assert damper.range == (0.0, 3.212)
        assert "(4.6) to (4.8)" in damper.provenance["source"]
        with pytest.raises(RangeError):
            damper.at(3.6)
        with pytest.warns(ExtrapolationWarning):
            assert damper.at(3.6, allow_extrapolation=True).rho == pytest.approx(1592, abs=1)


class TestEquations:
    def test_the_cubics_come_back_at_the_applied_voltages_only(self) -> None:
        part = equations(PUBLISHED)
        recovered = [f for f in part.compared if f.artefact in ("(4.6)", "(4.7)", "(4.8)")]
        assert len(recovered) == 12
        assert {f.verdict for f in recovered} == {"agrees"}
        assert max(abs(f.ours / f.published - 1) for f in recovered) < 4e-4
        off = one(part, "Printed voltages", "kw at the printed 0.88 V")
        assert off.ours - off.published == pytest.approx(-1.47, abs=0.005)
        ten = one(part, "(4.8) from all ten rows", "ρ")
        assert ten.ours / ten.published - 1 == pytest.approx(-0.0132, abs=2e-4)
        assert "3.674 V" in one(part, "Range of (4.6) to (4.8)", "the highest").reason

    def test_an_altered_coefficient_differs(self) -> None:
        cubics = dict(PUBLISHED.cubics) | {"kw": (*PUBLISHED.cubics["kw"][:3], PrintedNumber("3.6190"))}
        part = equations(replace(PUBLISHED, cubics=cubics))
        assert one(part, "(4.7)", "kw: coefficient of v³").verdict == "differs"
        assert one(part, "(4.7)", "kw: coefficient of v²").verdict == "agrees"
