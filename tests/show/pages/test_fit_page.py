"""The page of a fit says what was found and how far to trust it, whatever the fit was."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.show.fit_examples import records
from tests.show.pages.test_html_page import Reader

from dampyr.identification import Fit, fit
from dampyr.records import Record
from dampyr.show.pages.result_page import write_page


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
@pytest.mark.usefixtures("no_trials")
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


@pytest.mark.usefixtures("figures_not_rendered")
@pytest.mark.usefixtures("no_trials")
def test_a_misfit_is_told_before_anything_else(tmp_path: Path) -> None:
    skewed = [replace(r, force=r.force + 3000.0 * np.abs(r.velocity)) for r in records()]
    reader = Reader(write_page(fit(skewed, "dahl"), tmp_path / "page.html").read_text("utf-8"))
    text = " ".join(reader.inside("p"))
    assert text.index("Before you use the numbers:") < text.index("the intervals describe the fit")
    assert text.count("the intervals describe the fit") == 1
    assert "does not change its sign with the direction" in text
