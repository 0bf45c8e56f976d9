"""Laws that follow the temperature: fitted where the records vary in it, refused where they do not."""

from pathlib import Path

import numpy as np
import pytest
from tests.identification.synthetic import sine

from dampyr.errors import InputError, RangeError
from dampyr.identification import FitOptions, fit, score
from dampyr.identification.scoring.validation import cross_validate
from dampyr.models import Constant, Damper, Interpolation, WithTemperature
from dampyr.records import Record
from dampyr.show.identification.result import parameter_table

VOLTS, COLD, WARM = (0.0, 2.0), 15.0, 45.0
TRUTH = Damper(
    "dahl",
    {
        "dahl.kx": WithTemperature(
            Interpolation(VOLTS, (900.0, 2500.0)), Interpolation(VOLTS, (600.0, 1800.0)), (COLD, WARM)
        ),
        "dahl.kw": Interpolation(VOLTS, (60.0, 400.0)),
        "dahl.rho": 2500.0,
    },
)
LAWS = {"dahl.kx": "interpolation+temperature", "dahl.rho": "constant"}


def warmed(temperatures: tuple[float, ...], noise: float = 1.0) -> list[Record]:
    """A record at each input and temperature; during each the temperature rises by a degree about its mean."""
    records = []
    for u in VOLTS:
        for k, T in enumerate(temperatures):
            made = sine(TRUTH.at_temperature(T), u, f"{u:g}V-{T:g}C-{k}", 0.005 + 0.001 * k, noise=noise, seed=k)
            channel = np.linspace(T - 0.5, T + 0.5, made.n)
            records.append(made.replace(note="with its temperature", temperature=channel))
    return records


@pytest.fixture(scope="module")
def records() -> list[Record]:
    return warmed((COLD, 20.0, 30.0, 38.0, WARM))


def test_what_follows_the_temperature_comes_back(records: list[Record]) -> None:
    fit_result = fit(records, "dahl", laws=LAWS)
    assert fit_result.converged, fit_result.reason
    truth = {"0 V, 15": 900.0, "2 V, 15": 2500.0, "0 V, 45": 600.0, "2 V, 45": 1800.0}
    for at, value in truth.items():
        label = f"dahl.kx @ {at} °C"
        assert fit_result.parameters[label] == pytest.approx(value, rel=0.01)
        low, high = fit_result.intervals(0.999)[label]
        assert low < value < high
    damper = fit_result.damper
    assert damper is not None
    assert damper.temperatures == (COLD, WARM)
    np.testing.assert_allclose(damper.at_temperature(30.0).values(2.0)[0], 2150.0, rtol=0.01)
    assert any(row[:2] == ["dahl.kx, 45 °C", "N s/mm"] for row in parameter_table(fit_result).rows)
    plain = fit(records, "dahl", laws={"dahl.rho": "constant"})
    assert max(s.l1 for s in fit_result.scores.values()) < 0.25 * max(s.l1 for s in plain.scores.values())


def test_records_are_predicted_at_their_own_temperature(records: list[Record]) -> None:
    done = cross_validate(records, "dahl", options=FitOptions(folds=5, laws=LAWS))
    assert max(s.l1 for s in done.scores.values()) < 0.02
    damper = fit(records, "dahl", laws=LAWS).damper
    assert damper is not None
    bare = records[0].replace(note="without temperature", temperature=None)
    with pytest.raises(InputError, match="parameters depend on its temperature, and the record has none"):
        score(damper, bare)


@pytest.mark.prove
def test_its_errors_are_those_of_repeated_fits() -> None:
    values, errors = [], []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        made = [
            r.replace(note="another gain", force=r.force * (1.0 + 0.03 * rng.standard_normal()))
            for r in warmed((COLD, 20.0, 30.0, 38.0, WARM))
        ]
        fit_result = fit(made, "dahl", laws=LAWS)
        values.append(list(fit_result.parameters.values())[:4])
        errors.append(list(fit_result.stderr.values())[:4])
    ratio = np.std(values, axis=0) / np.mean(errors, axis=0)
    assert np.all((ratio > 0.5) & (ratio < 2.0)), ratio


def test_the_card_holds_it_and_one_temperature_makes_an_ordinary_damper(records: list[Record], tmp_path: Path) -> None:
    damper = fit(records, "dahl", laws=LAWS).damper
    assert damper is not None
    read = Damper.load(damper.save(tmp_path / "card.toml"))
    assert read.all_laws == damper.all_laws
    at = read.at_temperature(25.0)
    assert at.temperatures is None
    assert at.provenance["temperature"] == "25 °C"
    share = (25.0 - COLD) / (WARM - COLD)
    assert at.covariance is not None
    assert read.covariance is not None
    w = np.array([1.0 - share, 0.0, share, 0.0])
    np.testing.assert_allclose(at.covariance[0, 0], w @ read.covariance[:4, :4] @ w)
    with pytest.raises(InputError, match=r"depend on its temperature; give one, such as damper.at_temperature\(25.0\)"):
        read.values(1.0)
    with pytest.raises(RangeError, match="60 °C is outside the calibrated temperatures 15 to 45 °C"):
        read.at_temperature(60.0)
    t = np.linspace(0.0, 1.0, 200)
    x = 0.005 * np.sin(2 * np.pi * t)
    np.testing.assert_array_equal(read.force(t, x, 1.0, temperature=25.0), at.force(t, x, 1.0))


def test_records_that_do_not_vary_in_it_are_refused(records: list[Record]) -> None:
    with pytest.raises(
        InputError, match=r"records' means lie between 20 and 20.5 °C; they must differ by 2 °C or more"
    ):
        fit(warmed((20.0, 20.5)), "dahl", laws=LAWS)
    bare = [r.replace(note="without", temperature=None) for r in records]
    with pytest.raises(InputError, match=r"dahl\.kx is to follow the temperature, but 10 of 10 records have none"):
        fit(bare, "dahl", laws=LAWS)
    with pytest.raises(InputError, match="what is added can be temperature only"):
        fit(records, "dahl", laws={"dahl.kx": "interpolation+weather"})


def test_records_at_one_temperature_an_input_do_not_determine_it() -> None:
    """Input and temperature change together: what is which, no fit can say, and the errors are infinite."""
    together = [r for r in warmed((COLD, WARM)) if ("15C" in r.name) == (r.voltage == 0.0)]
    fit_result = fit(together, "dahl", laws=LAWS)
    assert not np.isfinite(fit_result.stderr["dahl.kx @ 0 V, 45 °C"])
    assert not np.isfinite(fit_result.stderr["dahl.kx @ 2 V, 15 °C"])
    assert any("do not determine" in note or "at its limit" in note for note in map(str, fit_result.findings))


def test_a_law_of_temperature_is_checked() -> None:
    with pytest.raises(InputError, match="temperatures 40 and 20 °C of a law must rise"):
        WithTemperature(Constant(1.0), Constant(2.0), (40.0, 20.0))
    with pytest.raises(InputError, match="must be of one kind"):
        WithTemperature(Constant(1.0), Interpolation(VOLTS, (1.0, 2.0)), (20.0, 40.0))
