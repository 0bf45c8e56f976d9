"""The page of an acceptance: verdicts, points outside, and what was not judged."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.identification.synthetic import sine
from tests.show.pages.test_html_page import Reader

from dampyr.errors import InputError
from dampyr.identification import accept
from dampyr.identification.acceptance_tests.accept import Accepted
from dampyr.identification.acceptance_tests.acceptance import Acceptance
from dampyr.models import Damper, Interpolation
from dampyr.show.pages import acceptance_page
from dampyr.show.pages.blocks import FigureBlock
from dampyr.show.pages.result_page import write_page

CARD = Damper("dahl", {"dahl.kx": Interpolation((0.0, 2.0), (800.0, 1800.0)), "dahl.kw": 200.0, "dahl.rho": 3000.0})
GOOD = sine(CARD, 0.0, "good", 0.005, 1.2, noise=1.0)
WEAK = replace(sine(CARD, 1.0, "weak", 0.004, 1.3), name="weak")
WEAK = replace(WEAK, force=0.7 * WEAK.force)
BEYOND = replace(sine(CARD, 1.0, "beyond", 0.004, 1.3), voltage=3.0)


def written(acceptances: list[Acceptance], path: Path) -> tuple[Reader, str]:
    html = write_page(Accepted("my card.toml", tuple(acceptances)), path / "page.html").read_text("utf-8")
    reader = Reader(html)
    assert reader.open == []
    return reader, html


@pytest.mark.usefixtures("figures_not_rendered")
def test_a_page_says_who_passed_and_what_is_outside(tmp_path: Path) -> None:
    acceptances = list(accept([GOOD, WEAK, BEYOND], CARD, tolerance=0.15, force_slack=5.0).results)
    reader, html = written(acceptances, tmp_path)
    assert reader.inside("h1") == ["Judged by my card.toml"]
    assert "1 passed, 1 failed, 1 not judged" in " ".join(reader.inside("p"))
    assert "within ± 15 % and 5 N of the reference" in html
    for words in ("✓ passed", "✗ failed", "? not judged"):
        assert words in html
    assert "Voltage 3 V is outside the calibrated range 0 to 2 V." in reader.inside("td")
    assert html.count("<svg") == 4  # one for each input, and the shares of the band
    outside = acceptances[1].outside
    assert len(outside) == len(acceptances[1].points)
    assert reader.inside("td").count("weak") == 3 + len(outside)  # in short twice, its level, and the points


def test_the_loops_of_what_failed_stand_beside_their_bands(tmp_path: Path) -> None:
    """Worst first, each force that lies outside at its own peak velocity, without the offset that was judged without."""
    slightly = replace(WEAK, name="slightly", force=0.8 / 0.7 * WEAK.force)
    result = accept([GOOD, slightly, WEAK], CARD, tolerance=0.15)
    [block] = acceptance_page._failed(result)
    assert isinstance(block, FigureBlock)
    first, second = [panel for panel in block.figure.axes if panel.axison]
    assert [panel.get_title(loc="left") for panel in (first, second)] == ["weak", "slightly"]
    forces = [p for p in result.results[2].outside if p.quantity != "energy"]
    [marks] = [line for line in first.lines if line.get_label() == "outside"]
    assert list(marks.get_ydata()) == pytest.approx([p.measured for p in forces])
    assert np.max(np.abs(first.lines[0].get_ydata())) == pytest.approx(max(abs(p.measured) for p in forces), rel=0.1)
    [bands] = first.collections
    ends = np.array([segment[:, 1] for segment in bands.get_segments()])
    assert ends == pytest.approx(np.array([(p.low, p.high) for p in forces]))
    words = acceptance_page._verdict(result)
    worst = result.results[2].worst
    assert words.kind == "failed"
    assert f"{worst.low:.4g} to {worst.high:.4g}" in words.text
    assert acceptance_page._failed(Accepted("card", result.results)) == [], "records that are not at hand are not drawn"


@pytest.mark.usefixtures("figures_not_rendered")
def test_a_page_without_anything_outside_or_judged_says_so(tmp_path: Path) -> None:
    reader, _ = written(list(accept(GOOD, CARD).results), tmp_path)
    assert "No point lies outside." in reader.inside("p")
    assert "What was not judged" not in reader.inside("h2")
    still = GOOD.replace(note="still", displacement=np.zeros(GOOD.n), velocity=None)
    reader, _ = written(list(accept(still, CARD).results), tmp_path)
    assert {"No record has a whole cycle.", "No point was judged."} <= set(reader.inside("p"))
    assert "No whole cycle." in reader.inside("td")


def test_nothing_is_no_page(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no judgement to show"):
        write_page(Accepted("card", ()), tmp_path / "page.html")
