"""Laws of an input that varies and was measured with noise: they end where the command ends, and not where its noise does."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from dampyr.errors import InputError, RangeError
from dampyr.identification import FitOptions, fit, score
from dampyr.identification.fits.least_squares import prepared
from dampyr.identification.scoring.validation import cross_validate
from dampyr.models import Constant, Damper, Polynomial
from dampyr.options import options_of
from dampyr.records import Record
from dampyr.records.conditioning.nominal_input import commanded_input, without_noise_beyond

NOISE = 0.1  # V rms, of the channel of the voltage
STEP = 0.005  # s
TRUTH = Damper(
    "dahl",
    {
        "dahl.kx": Polynomial((900.0, -300.0), 0.0, 3.0),
        "dahl.kw": Polynomial((60.0, 150.0), 0.0, 3.0),
        "dahl.rho": 2500.0,
    },
)


def random_steps(seed: int, n: int) -> np.ndarray:
    """Levels of 0 to 2.25 V, those two among them, of a tenth of a second to a second each."""
    rng = np.random.default_rng(seed)
    levels = np.append([0.0, 2.25], rng.uniform(0.0, 2.25, n))
    return np.repeat(levels, rng.integers(20, 200, levels.size))[:n]


def four_levels(seed: int, n: int) -> np.ndarray:
    chosen = np.random.default_rng(seed).choice([0.75, 1.5], n // 100)
    chosen[:4] = 0.0, 2.25, 0.0, 2.25
    return np.repeat(chosen, 100)


def few_plateaus(seed: int, n: int) -> np.ndarray:
    return np.repeat([2.25, 0.0], n // 2)


def sine(seed: int, n: int) -> np.ndarray:
    return 1.125 + 1.125 * np.sin(2.0 * np.pi * 0.3 * STEP * np.arange(n) + seed)


COMMANDS: dict[str, tuple[Callable[[int, int], np.ndarray], float]] = {
    # and how far the ends may be from 0 and 2.25 V
    "random steps": (random_steps, 0.04),
    "four levels": (four_levels, 0.02),
    "few plateaus": (few_plateaus, 0.02),
    "sine": (sine, 0.08),
}


def record(command: str, seed: int = 0, noise: float = NOISE, n: int = 3000) -> Record:
    rng, t = np.random.default_rng(100 + seed), STEP * np.arange(n)
    u = COMMANDS[command][0](seed, n)
    x = 0.01 * np.sin(2.0 * np.pi * t) + 0.004 * np.sin(2.0 * np.pi * 2.3 * t + seed)
    v = np.gradient(x, t)
    force = TRUTH.force(t, x, voltage=u, velocity=v) + rng.normal(0.0, 3.0, n)
    return Record(t, x, force, velocity=v, voltage=u + rng.normal(0.0, noise, n), name=f"{command} {seed}")


@pytest.mark.parametrize("command", COMMANDS)
def test_the_command_is_read_off_a_channel_with_noise(command: str) -> None:
    made, tolerance = COMMANDS[command]
    for seed in range(3):
        u = made(seed, 6000)
        channel = u + np.random.default_rng(seed).normal(0.0, NOISE, u.size)
        assert channel.min() < -0.2 and channel.max() > 2.45  # noqa: PT018
        meant = commanded_input(channel)
        assert meant is not None
        assert meant.noise == pytest.approx(NOISE, rel=0.1)
        assert meant.low == pytest.approx(0.0, abs=tolerance)
        assert meant.high == pytest.approx(2.25, abs=tolerance)
        assert meant.plateaus == (command != "sine")
        assert commanded_input(u) is None  # no noise
    if command == "four levels":
        assert meant.levels == pytest.approx([0.0, 0.75, 1.5, 2.25], abs=0.02)


def test_a_short_pulse_is_a_command_and_two_false_samples_are_none() -> None:
    u = np.zeros(4000)
    u[2000:2020] = 3.0
    rng = np.random.default_rng(3)
    meant = commanded_input(u + rng.normal(0.0, NOISE, u.size))
    assert meant is not None
    assert (meant.low, meant.high) == pytest.approx((0.0, 3.0), abs=0.1)
    false = np.where(np.arange(4000) < 2000, 0.0, 2.0) + rng.normal(0.0, NOISE, 4000)
    false[[100, 3000]] = 9.0, -5.0
    meant = commanded_input(false)
    assert meant is not None
    assert (meant.low, meant.high) == pytest.approx((0.0, 2.0), abs=0.02)


@pytest.mark.parametrize(
    "command", [pytest.param(c, marks=[] if c in ("random steps", "sine") else [pytest.mark.prove]) for c in COMMANDS]
)
def test_laws_and_card_end_at_the_command_and_the_notes_say_so(command: str) -> None:
    records = [record(command, seed) for seed in range(2)]
    result = fit(records, "dahl", laws={"*": "polynomial:1", "dahl.rho": "constant"})
    assert result.damper is not None, result.reason
    tolerance = COMMANDS[command][1]
    assert result.damper.range == pytest.approx((0.0, 2.25), abs=tolerance)
    assert result.problem.columns[1].knots == result.damper.range
    [note] = [note for note in map(str, result.findings) if "has noise" in note]
    assert note.startswith(f"the voltage of {command} 0, {command} 1 varies and has noise (up to 0.1")
    assert ("of its plateaus" in note) == (command != "sine")
    assert max(one.l1 for one in result.scores.values()) < 0.08
    # what the noise of another record reaches beyond the range is no extrapolation, a command beyond it is
    assert score(result.damper, record(command, 7)).l1 < 0.08
    beyond = record(command, 7)
    beyond = beyond.replace(note="more", voltage=1.2 * beyond.voltage)
    with pytest.raises(RangeError, match="is outside the calibrated range"):
        score(result.damper, beyond)
    assert cross_validate(records, "dahl", options=FitOptions(folds=2, laws="polynomial:1")).error < 0.08


def test_plateaus_that_agree_between_records_are_one_and_give_no_higher_degree() -> None:
    records = [record("few plateaus", seed) for seed in range(3)]
    knots = prepared("dahl", records).columns[0].knots
    assert knots == pytest.approx((0.0, 2.25), abs=0.01)
    steady = record("few plateaus", 9).replace(note="one voltage", voltage=2.25)
    assert prepared("dahl", [*records, steady]).columns[0].knots == (0.0, 2.25)


def test_inputs_without_noise_are_taken_as_they_are() -> None:
    for command in COMMANDS:
        clean = record(command, 0, noise=0.0)
        [piece] = prepared("dahl", [clean]).pieces
        np.testing.assert_array_equal(piece.u, clean.voltage[-piece.t.size :])
        assert piece.commanded is None
        assert without_noise_beyond(clean, 0.5, 1.0) is clean
    steady = record("sine").replace(note="one voltage", voltage=1.5)
    assert prepared("dahl", [steady]).pieces[0].u == 1.5


def test_a_fit_at_a_limit_is_saved_and_drawn_from(tmp_path: Path) -> None:
    """The viscous force of the truth changes its sign before the upper end, where the line of kx stands at its limit 0."""
    truth = Damper("dahl", {"dahl.kx": 0.0, "dahl.kw": Constant(90.0, 0.0, 3.0), "dahl.rho": 900.0})
    rng, t = np.random.default_rng(0), STEP * np.arange(3000)
    u = four_levels(0, t.size)
    x = 0.01 * np.sin(2.0 * np.pi * t)
    v = np.gradient(x, t)
    force = truth.force(t, x, voltage=u, velocity=v) + (600.0 - 400.0 * u) * v
    record = Record(t, x, force + rng.normal(0.0, 1.0, t.size), velocity=v, voltage=u + rng.normal(0.0, NOISE, t.size))
    result = fit(record, "dahl", laws="polynomial:1")
    assert result.damper is not None, result.reason
    assert any("stands at its limit" in note for note in map(str, result.findings))
    assert min(result.damper.all_laws["dahl.kx"].extremes()) >= 0.0
    card = result.damper.save(tmp_path / "card.toml")
    assert Damper.load(card).all_laws == result.damper.all_laws


def test_laws_for_all_and_by_name_go_together() -> None:
    laws = next(option for option in options_of(FitOptions) if option.name == "laws")
    assert laws.from_terminal(("polynomial:1",)) == "polynomial:1"
    assert laws.from_terminal(("dahl.rho=constant",)) == {"dahl.rho": "constant"}
    both = laws.from_terminal(("polynomial:1", "dahl.rho=constant"))
    assert both == {"*": "polynomial:1", "dahl.rho": "constant"}
    kinds = {c.name: c.kind for c in prepared("dahl", [record("four levels")], FitOptions(laws=both)).columns}
    assert kinds == {"dahl.kx": "polynomial", "dahl.kw": "polynomial", "dahl.rho": "constant"}
    with pytest.raises(InputError, match=r"--law constant and --law polynomial:1 are both for all parameters"):
        laws.from_terminal(("constant", "polynomial:1", "dahl.rho=constant"))
    assert laws.from_terminal(()) is None
