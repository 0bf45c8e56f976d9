"""Pages as paper: the answer on the first sheet, and few of them."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from dampyr import structures, studies
from dampyr.ground_motions import el_centro
from dampyr.identification import Fit, accept, fit
from dampyr.records import read_campaign
from dampyr.show.pages.result_page import write_page
from dampyr.studies.raminelli_2020 import reproduce

pytestmark = pytest.mark.prove


@pytest.fixture(scope="module")
def published_fit(campaign_folder: Path) -> Fit:
    """The fit of the whole campaign, whose page had eleven sheets at 22f2912."""
    return fit(read_campaign(campaign_folder), "dahl")


def printed(path: Path) -> int:
    """How many sheets Chromium prints of a page."""
    chromium = shutil.which("chromium")
    if chromium is None:
        pytest.skip("there is no chromium; make chromium installs it")
    out = path.with_suffix(".pdf")
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--no-pdf-header-footer", f"--print-to-pdf={out}"]
    subprocess.run([chromium, *options, str(path)], check=True, capture_output=True, timeout=120)
    return len(re.findall(rb"/Type\s*/Page[^s]", out.read_bytes()))


def test_a_fit_of_38_records_has_six_sheets_with_verdict_and_loops_on_the_first(
    published_fit: Fit, tmp_path: Path
) -> None:
    path = write_page(published_fit, tmp_path / "fit.html")
    assert printed(path) <= 6
    first = path.read_text("utf-8").partition("<h2>Findings</h2>")[0]
    assert 0 < first.index("does not describe these records") < first.index("<svg") < first.index("<table")


def test_the_study_has_twelve_sheets_with_one_figure_of_all_numbers_first(
    campaign_folder: Path, tmp_path: Path
) -> None:
    study = reproduce(campaign_folder, tmp_path)
    assert study.page is not None
    assert printed(study.page) <= 12
    html = study.page.read_text("utf-8")
    assert html.index("<svg") < html.index("<table")


def test_an_acceptance_has_its_limits_and_the_loops_of_what_failed_first(published_fit: Fit, tmp_path: Path) -> None:
    assert published_fit.damper is not None
    path = write_page(accept(list(published_fit.records), published_fit.damper), tmp_path / "accept.html")
    assert printed(path) <= 8
    first = path.read_text("utf-8").partition("<h2>How much of the band is used</h2>")[0]
    assert re.search(r"the worst point is the .* where .* are allowed", first)
    assert first.count("<svg") == 1


def test_a_response_of_five_cases_has_three_sheets_and_its_loops_on_the_first(tmp_path: Path) -> None:
    damper = studies.raminelli_2020.damper()
    laws = [structures.control_law(name, high=3.212) for name in ("on_off", "clipped_optimal")]
    result = structures.respond(structures.two_storey(), el_centro(), damper, voltage=[0.0, 1.98, *laws])
    path = write_page(result, tmp_path / "response.html")
    assert printed(path) <= 3
    first = path.read_text("utf-8").partition("Floors and energies</h2>")[0]
    assert first.count("<svg") == 1
