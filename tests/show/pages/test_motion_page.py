"""The page of a ground motion: measures, histories, spectra and processing."""

from pathlib import Path

import numpy as np
import pytest
from tests.show.pages.test_html_page import Reader

from dampyr.ground_motions import GroundMotion
from dampyr.show.pages.result_page import write_page

T = np.arange(0.0, 4.0, 0.02)
MOTION = GroundMotion(3.0 * np.sin(2 * np.pi * T), 0.02, name="A sine", source="made up")


@pytest.mark.usefixtures("figures_not_rendered")
def test_its_sections_hold_what_was_asked_for(tmp_path: Path) -> None:
    html = write_page(MOTION, tmp_path / "m.html", dampings=(0.05, 0.2), periods=(0.01, 0.5)).read_text("utf-8")
    reader = Reader(html)
    assert reader.inside("h1") == ["A sine"]
    assert reader.inside("h2")[:4] == ["Intensity measures", "Over time", "Response spectra", "Processing"]
    keys = [float(attrs["data-key"]) for tag, attrs in reader.tags if tag == "td" and _is_number(attrs.get("data-key"))]
    assert any(key == pytest.approx(3.0, rel=2e-2) for key in keys)  # the peak, and the spectrum of a stiff oscillator
    assert {0.01, 0.5} <= set(keys)
    assert html.count("<svg") == 3  # histories, pseudo-acceleration, displacement
    assert "None: the samples are as they were read or generated." in html
    assert "made up" in html


def test_processing_is_told_a_sentence_each(tmp_path: Path, figures_not_rendered: None) -> None:
    html = write_page(MOTION.scaled(0.5), tmp_path / "m.html", dampings=(0.05,), periods=(0.5,)).read_text("utf-8")
    assert "scaled" in html[html.index('id="processing"') :].lower()
    assert "None: the samples" not in html


def _is_number(text: str | None) -> bool:
    try:
        return text is not None and bool(np.isfinite(float(text)))
    except ValueError:
        return False
