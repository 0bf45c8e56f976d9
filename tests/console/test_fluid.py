"""A browser beside a rig that samples two channels at 10 kHz in real time: the page hears 20 frames a second and draws them."""

from pathlib import Path

import pytest

pytestmark = pytest.mark.by_hand

pytest.importorskip("fastapi")

RIG = """
[board]
rate = "10 kHz"
[wires]
temperature = "ai1"
"""
CAMPAIGN = """
name = "fast"
check_amplitude = 0.0
[[step]]
kind = "sine"
amplitude = "4 mm"
frequency = "2 Hz"
cycles = 40
voltage = "0.8712 V"
"""
SECONDS = 8
WATCH = """seconds => new Promise((done) => {
  const seen = { gaps: [], drawn: 0 };
  const canvas = document.querySelector(".live canvas");
  const begun = performance.now();
  let last = begun, before = "";
  const look = (now) => {
    seen.gaps.push(now - last);
    last = now;
    const after = canvas.toDataURL();
    seen.drawn += after !== before;
    before = after;
    if (now - begun < 1000 * seconds) requestAnimationFrame(look);
    else done(seen);
  };
  requestAnimationFrame(look);
})"""


@pytest.fixture
def data(tmp_path: Path) -> Path:
    """A data folder with a quick rig and a campaign of twenty seconds."""
    folder = tmp_path / "data"
    for place, text in (("rigs/quick/rig.toml", RIG), ("campaigns/fast.toml", CAMPAIGN)):
        (folder / place).parent.mkdir(parents=True)
        (folder / place).write_text(text)
    return folder


def test_the_page_is_fluid_at_10_khz(address, new_page, data, endurance):
    page = new_page(f"{address}#/bench")
    page.get_by_label("Rig", exact=True).select_option("quick")
    page.locator("#connect").click()
    page.locator("#arm:enabled").wait_for()
    page.get_by_text("10000 samples/s").wait_for()
    page.locator("#start:enabled").click()
    page.locator("#start-now:enabled").click()
    page.wait_for_function('() => document.querySelector("#run").textContent.includes("testing")')
    seen = page.evaluate(WATCH, SECONDS)
    gaps = sorted(seen["gaps"])
    endurance.report(
        "a page beside a rig that samples two channels at 10 kHz",
        None,
        f"{len(gaps) / SECONDS:.0f} pictures/s, {seen['drawn'] / SECONDS:.0f} of them new; longest gap {gaps[-1]:.0f} ms",
    )
    assert seen["drawn"] >= 10 * SECONDS, "new pictures a second"
    assert gaps[len(gaps) // 2] <= 50, "ms between two pictures, median"
    assert gaps[-1] <= 500, "ms without a picture, at most"
    page.keyboard.press("Escape")
    page.get_by_text("the table is braked and the coil is off").wait_for()
