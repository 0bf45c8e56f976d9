"""The page of a fit says what was found and how far to trust it, whatever the fit was."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.identification.synthetic import sine
from tests.show.pages.test_html_page import Reader

from dampyr.identification import Fit, Score, fit
from dampyr.identification.scoring.validation import Fold, Validation
from dampyr.models import Damper, Interpolation
from dampyr.records import Record
from dampyr.show.pages.blocks import Section, Text
from dampyr.show.pages.fit_sections import correlation_blocks, parameter_tables
from dampyr.show.pages.prediction_section import prediction_section
from dampyr.show.pages.range_section import range_section, range_table
from dampyr.show.pages.result_page import write_page

VOLTS = (0.0, 1.0, 2.0)
DAHL = Damper(
    "dahl",
    {
        "dahl.kx": Interpolation(VOLTS, (800.0, 1300.0, 1800.0)),
        "dahl.kw": Interpolation(VOLTS, (50.0, 200.0, 350.0)),
        "dahl.rho": 3000.0,
    },
)


def records(volts: tuple[float, ...] = VOLTS, each: int = 2) -> list[Record]:
    return [
        sine(DAHL, u, f"{u:g}V-{k}", 0.004 + 0.002 * k, 1.3 - 0.2 * k, noise=1.0, seed=k)
        for u in volts
        for k in range(each)
    ]


@pytest.fixture(scope="module")
def joint() -> Fit:
    return fit(records(), "dahl")


def as_current(record: Record) -> Record:
    return replace(record, current=record.voltage, voltage=None)


def unknown(fit_result: Fit) -> Fit:
    """As where the records hold nothing of one number and another stands at its limit."""
    first, second, *_ = fit_result.parameters
    r = fit_result.correlation.copy()
    r[0, :] = r[:, 0] = np.nan
    return replace(
        fit_result,
        stderr=fit_result.stderr | {first: np.inf, second: np.nan},
        naive_stderr=fit_result.naive_stderr | {first: np.inf, second: np.nan},
        correlation=r,
    )


def walk(name: str) -> Record:
    """A motion without a whole cycle."""
    t = np.arange(0.0, 5.0, 0.01)
    x = 0.01 * np.tanh(t - 2.0)
    v = np.gradient(x, t)
    noise = np.random.default_rng(1).normal(0.0, 1.0, t.size)
    return Record(time=t, displacement=x, velocity=v, force=900.0 * v + noise, voltage=1.0, name=name)


CASES: dict[str, Callable[[], Fit]] = {
    "several inputs": lambda: fit(records(), "dahl"),
    "a single record": lambda: fit(records((1.0,), 1), "dahl"),
    "one voltage": lambda: fit(records((2.0,), 3), "dahl"),
    "current": lambda: fit([as_current(r) for r in records()], "dahl"),
    "no damper": lambda: replace(
        fit(records(), "dahl"), bare=None, converged=False, reason="the numbers make no damper"
    ),
    "unknown errors": lambda: unknown(fit(records(), "dahl")),
    "one parameter": lambda: fit(records((1.0,), 1), "dahl", fixed={"dahl.kw": 200.0, "dahl.rho": 3000.0}),
    "no whole cycle": lambda: fit([walk("one"), walk("two")], "dahl", fixed={"dahl.kw": 1.0, "dahl.rho": 3000.0}),
    "an input each": lambda: fit(records(tuple(np.linspace(0.0, 2.0, 9)), 1), "dahl", laws="polynomial:1"),
    "a varying input": lambda: fit(
        [replace(r, voltage=np.linspace(0.9, 1.1, r.n)) for r in records((1.0,))], "dahl", laws="constant"
    ),
}


@pytest.mark.prove
@pytest.mark.parametrize("name", CASES)
def test_a_page_is_written_for_every_kind_of_fit(name: str, tmp_path: Path) -> None:
    fit_result = CASES[name]()
    html = write_page(fit_result, tmp_path / "page.html").read_text("utf-8")
    reader = Reader(html)
    assert reader.open == []
    ids = reader.values("id")
    assert len(ids) == len(set(ids))
    titles = reader.inside("h2")
    for title in ("In short", "Errors and laws of the parameters", "Calibrated range", "Residuals"):
        assert title in titles
    assert {label.partition(" @ ")[0] for label in fit_result.parameters} <= set(reader.values("data-key"))
    assert not re.search(r"\bnan\b|\binf\b", " ".join(reader.inside("p") + reader.inside("td") + reader.inside("text")))
    fixed = set(re.findall(r"(?:fill|stroke): (#\w+)", html))
    assert fixed <= {"#ffffff"}, "a fixed colour would vanish on a dark page"
    if name == "current":
        assert "current [A]" in html
        assert "voltage [V]" not in html
        assert "0, 1, 2 A" in html


@pytest.mark.prove
def test_errors_of_one_or_two_records_are_labelled_and_give_no_interval(tmp_path: Path) -> None:
    fit_result = fit([*records((0.0,), 3), *records((2.0,), 2)], "dahl", laws={"dahl.rho": "constant"})
    values, _, errors = parameter_tables(fit_result)
    assert values.columns == ("parameter", "unit", "all inputs", "0 V", "2 V")
    by_name = {row[0]: row for row in values.rows}
    assert "±" in by_name["dahl.kx"][3]
    assert "no interval" in by_name["dahl.kx"][4]
    assert by_name["dahl.rho"][3:] == ["", ""]
    assert "±" in by_name["dahl.rho"][2]
    labelled = [row[4] for row in errors.rows if row[4]]
    assert all("within these records only" in cell for cell in labelled)
    assert len(labelled) == 2
    html = write_page(fit_result, tmp_path / "page.html").read_text("utf-8")
    assert "2 of these errors hold within these records only" in html
    assert "between-record variance is not estimated from 2 records" in html.lower()


def test_intervals_are_those_of_the_fit_in_the_units_of_people() -> None:
    fit_result = fit(records((1.0, 2.0), 3), "dahl")
    values, _, errors = parameter_tables(fit_result)
    row = next(row for row in values.rows if row[0] == "dahl.kx")
    label = "dahl.kx @ 1 V"
    low, high = fit_result.intervals()[label]
    shown = row[values.columns.index("1 V")]
    assert shown == f"{1e-3 * fit_result.parameters[label]:.4g} ± {0.5e-3 * (high - low):.2g}"
    assert row[1] == "N s/mm"
    error = next(row for row in errors.rows if row[0] == "dahl.kx")[errors.columns.index("1 V")]
    assert error == f"{1e-3 * fit_result.stderr[label]:.2g} ({1e-3 * fit_result.naive_stderr[label]:.2g})"


def test_strong_pairs_are_told_in_words(joint: Fit) -> None:
    m = len(joint.parameters)
    r = np.eye(m)
    r[0, 2] = r[2, 0] = -0.97
    r[1, 3] = r[3, 1] = 0.6
    names = list(joint.parameters)
    text = correlation_blocks(replace(joint, correlation=r))[0]
    assert isinstance(text, Text)
    assert f"{names[0]} and {names[2]} (−0.97)" in text.text
    assert names[1] not in text.text
    r[0, 2] = r[2, 0] = np.nan
    text = correlation_blocks(replace(joint, correlation=r))[0]
    assert isinstance(text, Text)
    assert f"beyond ±0.9; the strongest are {names[1]} and {names[3]} (0.60)" in text.text


def test_the_calibrated_range_is_that_of_the_damper(joint: Fit) -> None:
    assert joint.damper is not None
    rows = {row[0]: row[1:4] for row in range_table(joint.damper).rows}
    assert rows["voltage"] == [0.0, 2.0, "V"]
    assert rows["displacement from the middle"][1:] == [pytest.approx(6.0, rel=0.02), "mm"]
    assert rows["frequency"] == [pytest.approx(1.1, rel=0.02), pytest.approx(1.3, rel=0.02), "Hz"]
    assert len(range_section(joint).blocks) == 2


def some_score(template: Score, l1: float) -> Score:
    return replace(template, l1=l1)


@pytest.mark.usefixtures("figures_not_rendered")
def test_predictions_say_what_they_were_not_fitted_on_and_sections_come_first(joint: Fit, tmp_path: Path) -> None:
    names = [r.name for r in joint.records]
    one = joint.scores[names[0]]
    folds = (
        Fold(
            tuple(names[2:]),
            {names[0]: some_score(one, 0.25), names[1]: some_score(one, 0.35)},
            True,
            "",
            {names[1]: "too fast"},
        ),
        Fold(tuple(names[:2]), {}, False, "a law fell below 0", {}),
    )
    section = prediction_section(joint, [Validation("record", folds)])
    table, parts = section.blocks[-2:]
    assert [list(row) for row in table.rows] == [
        [names[0], 1, 25.0, 100 * one.relevelled_l1, 100 * one.l1, 100 * one.nrmse, "nothing"],
        [names[1], 1, 35.0, 100 * one.relevelled_l1, 100 * joint.scores[names[1]].l1, 100 * one.nrmse, "too fast"],
    ]
    assert [list(row) for row in parts.rows] == [
        [1, len(names) - 2, f"{names[0]}, {names[1]}"],
        [2, 2, "no damper: a law fell below 0"],
    ]
    extra = [Section("Which model", [Text("The leader.")]), Section("Another", [Text("More.")])]
    predicted = replace(joint, validations=(Validation("record", folds),))
    path = write_page(predicted, tmp_path / "page.html", sections=extra)
    html = path.read_text("utf-8")
    titles = Reader(html).inside("h2")
    assert titles[:4] == ["In short", "Which model", "Another", "Findings and search"]
    first = titles.index("Goodness of fit")
    assert titles[first + 1] == "Prediction of unseen records"
    assert "L1 30 % on average, 2 records, split by record" in html


@pytest.mark.usefixtures("first_figure_rendered")
def test_its_first_screen_has_the_verdict_the_loops_and_the_parameters(joint: Fit, tmp_path: Path) -> None:
    html = write_page(joint, tmp_path / "page.html").read_text("utf-8")
    first = html[html.index('<section id="in-short">') : html.index("</section>")]
    assert first.count("<svg") == first.count("<table") == 1
    places = [first.index(joint.verdict.words), first.index("<svg"), first.index("<table")]
    assert places == sorted(places)
    for word in ("0 V", "1 V", "2 V", "measured", "fit"):
        assert f"{word}</text>" in first
    assert len(re.findall(r">[^<]*\(no interval\)<", first)) == len(joint.parameters) == 9
    assert html.index("</section>") < html.index("<nav")
    assert html.count("<nav") == 1


def test_a_validation_that_predicted_nothing_is_shown(joint: Fit) -> None:
    empty = Validation("input", (Fold(("a",), {}, False, "no damper came of it", {}),))
    text, parts = prediction_section(joint, [empty]).blocks[1:]
    assert "No part was predicted" in text.text
    assert list(parts.rows[0]) == [1, 1, "no damper: no damper came of it"]


@pytest.mark.usefixtures("figures_not_rendered")
def test_a_misfit_is_told_before_anything_else(tmp_path: Path) -> None:
    skewed = [replace(r, force=r.force + 3000.0 * np.abs(r.velocity)) for r in records()]
    reader = Reader(write_page(fit(skewed, "dahl"), tmp_path / "page.html").read_text("utf-8"))
    text = " ".join(reader.inside("p"))
    assert text.index("Before you use the numbers:") < text.index("the intervals describe the fit")
    assert text.count("the intervals describe the fit") == 1
    assert "does not change its sign with the direction" in text
