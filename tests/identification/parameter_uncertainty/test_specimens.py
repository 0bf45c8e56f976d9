"""Mean and spread over specimens: closed forms, what is left out and why, and how often intervals hold the truth."""

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.signal import lfilter
from scipy.stats import t
from tests.endurance import Endurance

import dampyr as dp
from dampyr.cli import cli
from dampyr.errors import InputError
from dampyr.identification import fit_specimens, score
from dampyr.identification.parameter_uncertainty.random_effects import random_effects
from dampyr.identification.parameter_uncertainty.specimens import Specimens
from dampyr.models import Damper
from dampyr.records import Record, write
from dampyr.show.identification.specimens import mean_and_spread

TRUTH = {"dahl.kx": 1300.0, "dahl.kw": 210.0, "dahl.rho": 6000.0}
SPREAD = 0.1
DT = 0.01  # s


def specimen(
    name: str,
    truth: dict[str, float],
    rng: np.random.Generator,
    count: int = 8,
    voltage: float = 0.0,
    gain: float = 0.03,
) -> list[Record]:
    """A small campaign on one damper: sines, noise that is correlated over 0.33 s, a gain of each record."""
    damper, t_, records = Damper("dahl", truth), np.arange(0.0, 6.0, DT), []
    for k in range(count):
        amplitude, frequency = rng.uniform(0.004, 0.012), rng.uniform(0.6, 1.4)
        run = np.maximum(t_ - 0.5, 0.0)
        x = amplitude * np.minimum(run * frequency, 1.0) * np.sin(2 * np.pi * frequency * run)
        v = np.gradient(x, t_)
        force = damper.force(t_, x, voltage=0.0, velocity=v, state0=[rng.uniform(-0.8, 0.8)])
        keep = float(np.exp(-DT / 0.33))
        spread = 0.04 * float(np.std(force)) * np.sqrt(1.0 - keep**2)
        noise = lfilter([1.0], [1.0, -keep], rng.normal(0.0, spread, t_.size + 200))[200:]
        force = (1.0 + gain * rng.standard_normal()) * force + noise + rng.normal(100.0, 10.0)
        records.append(Record(t_, x, force, velocity=v, voltage=voltage, name=f"{name}-{k}", specimen=name))
    return records


def specimens(seed: int, spread: float = SPREAD, number: int = 10, count: int = 8) -> list[Record]:
    """Records of several dampers of one type, each parameter lognormal."""
    rng = np.random.default_rng(seed)
    records: list[Record] = []
    for n in range(number):
        truth = {name: value * float(np.exp(spread * rng.standard_normal())) for name, value in TRUTH.items()}
        records += specimen(f"damper {n + 1}", truth, rng, count)
    return records


@pytest.fixture(scope="module")
def five() -> Specimens:
    return fit_specimens(specimens(0, number=5, count=4), "dahl")


@pytest.mark.prove
def test_of_records_without_spread_too() -> None:
    result = fit_specimens(specimens(3, spread=0.0, number=6), "dahl")
    for one in result.spreads.values():
        assert one.spread_interval[0] == 0.0, one
        assert one.spread < 0.05


def test_the_table_is_relative_where_a_parameter_is_positive(five: Specimens) -> None:
    for label, one in five.spreads.items():
        assert one.relative
        values = np.log(list(one.estimates.values()))
        assert np.log(one.mean) == pytest.approx(values.mean(), abs=0.05)
        assert one.spread_interval[0] <= one.spread <= one.spread_interval[1]
        assert one.new_specimen[0] < one.mean_interval[0] < one.mean < one.mean_interval[1] < one.new_specimen[1]
        for name, shrunken in one.shrunken.items():
            assert min(one.mean, one.estimates[name]) - 1e-9 <= shrunken <= max(one.mean, one.estimates[name]) + 1e-9
        assert one.unit == five.fits["damper 1"].units[label]
    table = mean_and_spread(five)
    heads, rows = table.columns, table.rows
    assert len(heads) == len(rows[0])
    assert rows[1][4].endswith(" %")
    assert list(five.to_dataframe().index) == list(five.spreads)
    assert [one.words for one in five.findings if one.severity == "note"] == [five.about_sessions]


def test_pooled_errors_share_what_records_differ_by_and_not_the_motions(five: Specimens) -> None:
    own = fit_specimens(specimens(0, number=5, count=4), "dahl", errors="own")
    for label, one in own.spreads.items():
        assert one.errors == pytest.approx({name: fitted.stderr[label] for name, fitted in own.fits.items()})
        pooled = np.array(list(five.spreads[label].errors.values()))
        assert np.std(np.log(pooled)) < np.std(np.log(list(one.errors.values())))


@pytest.mark.parametrize("number", [600, pytest.param(2000, marks=pytest.mark.prove)])
def test_the_damper_of_the_mean_and_new_ones(five: Specimens, number: int) -> None:
    damper = five.damper()
    assert damper.values(0.0) == pytest.approx([one.mean for one in five.spreads.values()])
    widths = np.sqrt(np.diag(damper.covariance)) / damper.coefficients
    expected = [0.5 * np.diff(np.log(one.new_specimen))[0] / t.ppf(0.975, 4) for one in five.spreads.values()]
    np.testing.assert_allclose(widths, expected)
    assert np.linalg.eigvalsh(damper.covariance / np.outer(damper.coefficients, damper.coefficients)).min() > -1e-12
    many = five.new_specimens(number, seed=1)
    table = np.array([one.values(0.0) for one in many])
    for column, one in zip(table.T, five.spreads.values(), strict=True):
        np.testing.assert_allclose(np.quantile(np.log(column), [0.025, 0.975]), np.log(one.new_specimen), atol=0.08)
    assert np.array_equal(table[:5], [one.values(0.0) for one in five.new_specimens(5, seed=1)])


def test_the_type_has_bands_and_its_draws_are_specimens(five: Specimens, tmp_path: Path) -> None:
    damper = dp.models.Damper.load(five.damper().save(tmp_path / "type.toml"))
    error = damper.prediction_error
    assert error is not None
    assert (error.sessions, error.session_sd, error.freedom, error.within_sessions) == ((), 0.0, 4.0, None)
    assert error.record_sd == pytest.approx(0.03, rel=0.5)
    assert "contains that of sessions" in error.session_source
    drawn = np.array([one.values(0.0) for one in damper.draws(1000, seed=2)]) / damper.values(0.0)
    plain = np.sqrt(np.diag(damper.covariance)) / damper.coefficients
    for k in range(3):
        width = 0.5 * np.diff(np.quantile(drawn[:, k], [0.16, 0.84]))[0]
        level = error.record_sd if k < 2 else 0.0  # rho has no newton
        assert width == pytest.approx(
            np.hypot(1.14 * plain[k], level), rel=0.08
        )  # 1.14: Student's t of 4 degrees of freedom
    record = specimen("another", TRUTH, np.random.default_rng(77), 1)[0]
    one = score(damper, record, band=0.9)
    assert one.band is not None
    assert one.band.session is None


def in_sessions(groups: dict[str, list[Record]], sessions: dict[str, str | None]) -> Specimens:
    named = {
        name: [each.replace(note="of a session", measurement_session=sessions[name]) for each in some]
        for name, some in groups.items()
    }
    return fit_specimens(named, "dahl")


def test_it_says_whether_sessions_are_in_the_spread() -> None:
    rng = np.random.default_rng(11)
    groups = {f"damper {n}": specimen(f"damper {n}", TRUTH, rng, 4) for n in range(3)}
    own = in_sessions(groups, {name: f"day of {name}" for name in groups})
    assert "test one specimen in the sessions of others" in own.findings[-1].words
    assert own.damper().prediction_error.session_sd == 0.0
    shared = in_sessions(groups, dict.fromkeys(groups, "Monday"))
    assert shared.findings[-1].words == (
        "every specimen was tested in Monday, so the spread between specimens contains none of sessions"
    )
    assert shared.damper().prediction_error.session_sd == pytest.approx(0.08)
    unnamed = in_sessions(groups, dict.fromkeys(groups))
    assert "the records do not say in which measurement session each specimen was tested" in unnamed.findings[-1].words


@pytest.mark.prove
@pytest.mark.endure
def test_bands_of_a_type_hold_the_records_of_a_new_specimen(endurance: Endurance) -> None:
    """Six specimens of five records, one record of another specimen each: 90 % bands."""
    repeats = 60 if endurance.full else 12
    peaks, samples = [], []
    for seed in range(repeats):
        damper = fit_specimens(specimens(3000 + seed, number=6, count=5), "dahl").damper()
        rng = np.random.default_rng(seed)
        truth = {name: value * float(np.exp(SPREAD * rng.standard_normal())) for name, value in TRUTH.items()}
        band = score(damper, specimen("another", truth, rng, 1)[0], band=0.9).band
        assert band is not None
        peaks.append(band.peak.holds)
        samples.append(band.holds)
    figures = (
        f"{repeats} repeats: {100 * np.mean(peaks):.1f} % of the peaks, {100 * np.mean(samples):.1f} % of the samples"
    )
    endurance.report("90 % bands of a new specimen, of a type of six specimens of five records", 0, figures)
    few = 0.0 if endurance.full else 0.10  # two standard errors of 12 repeats are as much more than those of 60
    assert 0.83 - few <= np.mean(peaks) <= 0.99 + few
    assert 0.85 - few <= np.mean(samples) <= 0.97 + few


@pytest.mark.prove
def test_what_goes_together_between_specimens_is_seen() -> None:
    rng, records = np.random.default_rng(5), []
    for n in range(8):
        factor = float(np.exp(0.15 * rng.standard_normal()))
        truth = {"dahl.kx": 1300.0 * factor, "dahl.kw": 210.0 * factor, "dahl.rho": 6000.0}
        records += specimen(f"damper {n}", truth, rng, 5)
    result = fit_specimens(records, "dahl")
    assert result.between[0, 1] > 0.5  # of eight specimens, with kx known to 7 %


def test_specimens_and_numbers_that_cannot_be_used_are_named() -> None:
    rng = np.random.default_rng(6)
    groups = {f"damper {n}": specimen(f"damper {n}", TRUTH, rng, 4) for n in range(4)}
    groups["damper 3"] = groups["damper 3"][:2]
    turned = [r.replace(note="turned", force=-r.force) for r in specimen("damper 4", TRUTH, rng, 4)]
    result = fit_specimens(groups | {"damper 4": turned}, "dahl")
    assert set(result.left_out) == {"damper 4"}
    assert "sign is inverted" in result.left_out["damper 4"]
    for one in result.spreads.values():
        assert one.left_out == {"damper 3": "between-record variance is not estimated from 2 records"}
        assert set(one.estimates) == {"damper 0", "damper 1", "damper 2"}
    notes = [one for one in result.findings if one.severity == "note"]
    assert len(notes) == 5  # the last one says what of sessions is in the spread
    few = {name: some[:2] for name, some in groups.items() if name != "damper 0"}
    with pytest.raises(InputError, match="no number is determined in 3 specimens"):
        fit_specimens(few, "dahl")


def test_an_input_of_two_specimens_has_no_spread() -> None:
    rng = np.random.default_rng(7)
    groups = {f"damper {n}": specimen(f"damper {n}", TRUTH, rng, 4) for n in range(3)}
    for n in range(2):
        groups[f"damper {n}"] += [
            record.replace(note="another input", voltage=1.0, name=f"{record.name} at 1 V")
            for record in specimen(f"damper {n}", TRUTH, rng, 4)
        ]
    with pytest.raises(InputError, match="no number is determined"):
        fit_specimens(groups, "dahl")  # labels of one input alone differ from those of two
    rest = fit_specimens(groups, "dahl", laws="constant")
    assert set(rest.spreads) == set(TRUTH)


def test_wrong_calls_say_what_is_wrong() -> None:
    records = specimens(8, number=2, count=3)
    with pytest.raises(InputError, match=r"2 specimens \(damper 1, damper 2\) cannot give a spread"):
        fit_specimens(records, "dahl")
    with pytest.raises(InputError, match="damper 1-0 names no specimen; give it in a column specimen"):
        fit_specimens([records[0].replace(note="unnamed", specimen=None), *records[1:]], "dahl")
    with pytest.raises(InputError, match="'best' is an unknown kind of errors"):
        fit_specimens(records, "dahl", errors="best")
    with pytest.raises(InputError, match="level = 0"):
        fit_specimens(records, "dahl", level=0.0)
    for wrong in (([1.0, 2.0], [0.1, 0.1]), ([1.0, 2.0, 3.0], [0.1, 0.0, 0.1]), ([1.0, 2.0, np.nan], [0.1, 0.1, 0.1])):
        with pytest.raises(InputError):
            random_effects(*wrong)


def written(records: Sequence[Record], folder: Path) -> Path:
    for record in records:
        write(record, folder / f"{record.name}.h5")
    return folder


def test_the_command_prints_mean_and_spread(tmp_path: Path) -> None:
    folder = written(specimens(9, number=3, count=4), tmp_path)
    run = CliRunner()
    card = tmp_path / "type.toml"
    done = run.invoke(cli, ["identify", str(folder), "--model", "dahl", "--by-specimen", "--save", str(card)])
    assert done.exit_code == 0, done.output
    assert "3 specimens (damper 1, damper 2, damper 3): mean and spread between them" in done.stdout
    assert dp.models.Damper.load(card).provenance["covariance"] == "of a new specimen"
    refused = run.invoke(cli, ["identify", str(folder), "--by-specimen"])
    assert refused.exit_code == 2
    assert "--by-specimen makes one fit of the --model per specimen" in refused.output


@pytest.mark.prove
def test_the_command_gives_them_as_json(tmp_path: Path) -> None:
    folder = written(specimens(9, number=3, count=4), tmp_path)
    done = CliRunner().invoke(cli, ["identify", str(folder), "--model", "dahl", "--by-specimen", "--json"])
    data = json.loads(done.stdout)
    assert set(data["parameters"]) == set(TRUTH)
    assert data["parameters"]["dahl.kw"]["relative"] is True


@pytest.mark.prove
@pytest.mark.endure
def test_intervals_hold_the_spread_and_the_mean_as_often_as_they_say(endurance: Endurance) -> None:
    """Ten specimens of eight records: the share of 95 % intervals that hold the truth, by parameter."""
    repeats = 100 if endurance.full else 5
    spreads, means = dict.fromkeys(TRUTH, 0), dict.fromkeys(TRUTH, 0)
    for seed in range(repeats):
        for label, one in fit_specimens(specimens(1000 + seed), "dahl").spreads.items():
            spreads[label] += one.spread_interval[0] <= SPREAD <= one.spread_interval[1]
            means[label] += one.mean_interval[0] <= TRUTH[label] <= one.mean_interval[1]
    shares = [", ".join(f"{k} {100 * v / repeats:.0f} %" for k, v in each.items()) for each in (spreads, means)]
    figures = f"{repeats} repeats: the spread {shares[0]}; the mean {shares[1]}"
    endurance.report("95 % intervals between ten specimens of eight records", 1000, figures)
    least = 0.90 if endurance.full else 0.75  # two standard errors of 5 repeats below 0.95
    assert min(spreads.values()) >= least * repeats
    assert min(means.values()) >= least * repeats


@pytest.mark.prove
@pytest.mark.endure
def test_five_specimens_of_three_records_hold_a_sixth(endurance: Endurance) -> None:
    """Spread and gains of 5 %, so that errors are nearly as large as the spread: it was 90 % of 95."""
    repeats, spread = 80 if endurance.full else 20, 0.05
    held = []
    for seed in range(repeats):
        rng = np.random.default_rng([7, seed])

        def one_of_the_type(rng: np.random.Generator = rng) -> dict[str, float]:
            return {name: value * float(np.exp(spread * rng.standard_normal())) for name, value in TRUTH.items()}

        records = [r for n in range(5) for r in specimen(f"damper {n}", one_of_the_type(), rng, 3, gain=0.05)]
        sixth = one_of_the_type()
        for label, one in fit_specimens(records, "dahl").spreads.items():
            held.append(one.new_specimen[0] <= sixth[label] <= one.new_specimen[1])
    figures = f"{repeats} repeats: {100 * np.mean(held):.1f} % of {len(held)}"
    endurance.report("95 % intervals of a sixth specimen after five of three records", 7, figures)
    few = 0.0 if endurance.full else 0.03  # of 60 intervals in the place of 240
    assert 0.92 - few <= np.mean(held) <= 0.995 + few
