"""True of every published set."""

from pathlib import Path

import numpy as np
import pytest

from dampyr.errors import RangeError
from dampyr.models import Damper, published


@pytest.mark.parametrize("name", published.available_sets())
def test_it_says_where_it_comes_from(name: str) -> None:
    about = published.about(name)
    assert min(map(len, (about.claims, about.paper, about.where, about.read, about.device, about.limits_from))) > 5
    assert len(about.notes) >= 1
    assert published.damper(name).provenance["paper"] == about.paper
    assert published.damper(name).provenance["read"] == about.read
    assert all(np.isfinite(number) and unit for number, unit in about.printed.values())
    assert ("eta" in about.printed) == (about.eta is not None)


@pytest.mark.parametrize("name", published.available_sets())
def test_differences_are_named_by_both(name: str) -> None:
    for other in published.about(name).differs:
        assert other != name
        assert name in published.about(other).differs


@pytest.mark.parametrize("name", published.available_sets())
def test_sets_that_claim_the_same_source_name_each_other(name: str) -> None:
    mine = published.about(name)
    same = {n for n in published.available_sets() if n != name and published.about(n).claims == mine.claims}
    assert same <= set(mine.differs)


# Their kernel takes long to compile.
LONG = ["eldorado_as_noted", "eldorado_as_run", "spencer_1997", "spencer_1997_baig", "spencer_1997_damper_lab"]
COMPILED = [pytest.param(name, marks=[pytest.mark.prove] * (name in LONG)) for name in published.available_sets()]


@pytest.mark.parametrize("name", COMPILED)
def test_sets_that_differ_do(name: str) -> None:
    u = published.about(name).limits[1]
    t = np.linspace(0.0, 1.0, 2000)
    x = 0.008 * np.sin(9.0 * t)
    mine = force(name, t, x, u)
    for other in published.about(name).differs:
        theirs = force(other, t, x, min(u, published.about(other).limits[1]))
        assert np.abs(mine - theirs).max() > 1e-3 * np.abs(mine).max()


def force(name: str, t: np.ndarray, x: np.ndarray, u: float) -> np.ndarray:
    given = {"voltage": u} if published.about(name).input == "V" else {"current": u}
    return published.damper(name).force(t, x, **given)


@pytest.mark.parametrize("name", COMPILED)
def test_every_cycle_of_its_sine_dissipates_more_with_more_input(name: str) -> None:
    motion = published.about(name).motion
    n = 2000
    t = np.arange(3 * n + 1) / (n * motion.frequency)
    x = motion.amplitude * np.sin(2.0 * np.pi * motion.frequency * t)
    work = []
    for u in motion.inputs:
        f = force(name, t, x, u)[-n - 1 :]
        work.append(np.sum(0.5 * (f[1:] + f[:-1]) * np.diff(x[-n - 1 :])))
    assert work[0] > 0.0
    assert np.all(np.diff(work) > 0.0)


@pytest.mark.parametrize("name", published.available_sets())
def test_it_holds_to_its_limits(name: str) -> None:
    low, high = published.about(name).limits
    damper = published.damper(name)
    assert damper.range == (low, high)
    assert all(low <= u <= high for u in published.about(name).motion.inputs)
    with pytest.raises(RangeError):
        damper.values(high + 0.1)


@pytest.mark.parametrize("name", published.available_sets())
def test_its_card_comes_back(name: str, tmp_path: Path) -> None:
    damper = published.damper(name)
    again = Damper.load(damper.save(tmp_path / "card.toml"))
    u = 0.4 * damper.range[1]
    np.testing.assert_array_equal(again.values(u), damper.values(u))
    assert again.provenance == damper.provenance
