"""What records cannot separate is named, with a test that would; nothing is named where they do."""

from pathlib import Path

import numpy as np
import pytest
from tests.identification.parameter_uncertainty.test_profile_likelihood import noisy_records
from tests.identification.synthetic import sine

from dampyr.identification import Fit, fit, identifiability
from dampyr.identification.parameter_uncertainty.identifiability import Inseparable
from dampyr.models import Damper, Interpolation
from dampyr.records import Record
from dampyr.show.pages.result_page import write_page

VOLTS = (0.0, 2.0)
TWO = Damper(
    "dahl",
    {
        "dahl.kx": Interpolation(VOLTS, (1200.0, 3000.0)),
        "dahl.kw": Interpolation(VOLTS, (80.0, 300.0)),
        "dahl.rho": Interpolation(VOLTS, (9000.0, 5000.0)),
    },
)
WIDE = ((0.012, 0.1), (0.001, 0.3), (0.006, 2.0), (0.010, 0.6), (0.002, 1.6), (0.004, 0.1))  # m, Hz
ALIKE = tuple((0.010 + 0.0004 * k, 1.05 - 0.01 * k) for k in range(6))


def records(
    motions: tuple[tuple[float, float], ...],
    volts: tuple[float, ...] = VOLTS,
    sessions: tuple[str | None, ...] | None = None,
) -> list[Record]:
    made = []
    for v, voltage in enumerate(volts):
        for k, (amplitude, frequency) in enumerate(motions):
            seconds = max(4.0, 3.5 / frequency)
            one = sine(
                TWO, voltage, f"{voltage:g}V-{k}", amplitude, frequency, noise=4.0, seed=100 * v + k, seconds=seconds
            )
            gain = 1.0 + 0.02 * np.random.default_rng(7 * k + v).standard_normal()
            session = sessions[v] if sessions else None
            made.append(one.replace(note="gain", force=gain * one.force, measurement_session=session))
    return made


def of_kind(fitted: Fit, kind: str) -> list[Inseparable]:
    return [one for one in identifiability(fitted).inseparable if one.kind == kind]


@pytest.fixture(scope="module")
def alike() -> Fit:
    """Of near-sines of one amplitude and speed, the larger the slower."""
    return fit(records(ALIKE), "dahl")


def test_kx_and_kw_trade_on_sines_of_one_speed_and_a_slow_test_separates_them(alike: Fit) -> None:
    pairs = [one for one in of_kind(alike, "pair") if set(one.labels) == {"dahl.kx @ 2 V", "dahl.kw @ 2 V"}]
    assert len(pairs) == 1
    (one,) = pairs
    assert one.numbers["correlation"] < -0.8
    assert one.numbers["correlation_with_the_test"] > one.numbers["correlation"]
    assert all(one.numbers[f"narrower {label}"] < one.numbers["narrower by a repeat"] for label in one.labels)
    assert one.numbers["frequency"] < 0.5
    assert "trade against each other" in one.words
    assert "2 V would" in one.test


def test_the_test_that_is_proposed_does_separate_them(alike: Fit) -> None:
    (one,) = [one for one in of_kind(alike, "pair") if one.labels[0] == "dahl.kx @ 2 V"]
    amplitude, frequency = one.numbers["amplitude"], one.numbers["frequency"]
    seconds = 6.0 / frequency + 0.5
    proposed = sine(TWO, 2.0, "proposed", amplitude, frequency, noise=4.0, seed=9, seconds=seconds)
    after = fit([*records(ALIKE), proposed], "dahl")
    again = of_kind(after, "pair")
    r = next((each.numbers["correlation"] for each in again if each.labels == one.labels), 0.0)
    assert r > one.numbers["correlation"] + 0.02
    assert r == pytest.approx(one.numbers["correlation_with_the_test"], abs=0.1) or r == 0.0


def test_amplitude_and_frequency_that_go_together_are_named(alike: Fit) -> None:
    (one,) = of_kind(alike, "amplitude and frequency")
    assert one.numbers["correlation"] == pytest.approx(-1.0)
    assert "at 0, 2 V" in one.words
    assert abs(one.numbers["correlation_with_the_test"]) < 0.7


def test_motions_that_differ_leave_neither() -> None:
    wide = fit(records(WIDE, sessions=("a", "a")), "dahl")
    assert identifiability(wide).inseparable == ()
    assert repr(identifiability(wide)).startswith("<Identifiability: 0 findings>")


@pytest.mark.parametrize(
    ("sessions", "words"),
    [
        ((None, None), "12 of 12 records name no session"),
        (("monday", "tuesday"), "0 V in monday, 2 V in tuesday"),
        (("monday", "monday"), ""),
    ],
)
def test_voltage_and_session(sessions: tuple[str | None, ...], words: str) -> None:
    kinds = of_kind(fit(records(WIDE, sessions=sessions), "dahl"), "input and session")
    if not words:
        assert kinds == []
        return
    (one,) = kinds
    assert words in one.words
    assert "repeat 0V-" in one.test
    assert "tuesday" in one.test or sessions == (None, None)


def test_a_repeated_test_ties_the_sessions() -> None:
    tied = records(WIDE, sessions=("monday", "tuesday"))
    sentinel = tied[2].replace(note="repeated", name="sentinel", measurement_session="tuesday")
    assert of_kind(fit([*tied, sentinel], "dahl"), "input and session") == []


def test_a_combination_and_the_stroke_that_would_part_it() -> None:
    tiny = fit(noisy_records(amplitude=(1e-7, 3e-7), count=4), "dahl")
    kinds = identifiability(tiny).inseparable
    about = [one for one in kinds if {"dahl.kw", "dahl.rho"} <= set(one.labels)]
    assert about, identifiability(tiny).lines


def test_numbers_at_a_limit_and_of_few_records() -> None:
    limited = fit(noisy_records(), "dahl + inertia")
    (one,) = of_kind(limited, "at a limit")
    assert one.labels == ("inertia.m",)
    (few,) = of_kind(fit(noisy_records(count=2), "dahl"), "few records")
    assert set(few.labels) == {"dahl.kx", "dahl.kw", "dahl.rho"}
    assert few.test == "record 3 or more at each voltage"


def test_it_stands_in_json_and_text(alike: Fit) -> None:
    lines = identifiability(alike).lines
    assert len(lines) == len(alike.as_dict()["identifiability"]) >= 3


@pytest.mark.prove
def test_it_stands_in_the_page(alike: Fit, tmp_path: Path) -> None:
    page = write_page(alike, tmp_path / "fit.html").read_text(encoding="utf-8")
    assert "What these records cannot separate" in page
    assert "trade against each other" in page


@pytest.mark.prove
def test_on_the_campaign_it_names_what_is_known_of_it(published_fit: Fit) -> None:
    fitted = published_fit
    first = identifiability(fitted)
    pairs = {one.labels: one for one in first.inseparable if one.kind == "pair"}
    one = pairs["dahl.kx @ 3.212 V", "dahl.kw @ 3.212 V"]
    assert one.numbers["correlation"] == pytest.approx(-0.82, abs=0.02)
    assert min(one.numbers[f"wider {label}"] for label in one.labels) > 1.5
    assert {label.split(" @ ")[1] for labels in pairs for label in labels} == {"0 V", "0.8712 V", "1.98 V", "3.212 V"}
    for labels, each in pairs.items():  # what docs/explanations/identification.md says of them
        assert all(0.675 <= each.numbers[f"narrower {label}"] <= 0.865 for label in labels)
        assert 0.935 <= each.numbers["narrower by a repeat"] <= 0.955
        assert 0.9e-3 <= each.numbers["amplitude"] <= 2.1e-3
    assert {each.kind for each in first.inseparable} == {"pair", "amplitude and frequency", "input and session"}
    assert identifiability(fitted) == first
