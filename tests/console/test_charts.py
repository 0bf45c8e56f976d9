"""Charts in a browser: linked, switchable, in the colours of the page, from the installed package alone."""

import re

import numpy as np
import pytest

pytest.importorskip("fastapi")
pytest.importorskip("bokeh")

from dampyr import records
from dampyr.console import application

VIOLATIONS = """addEventListener("securitypolicyviolation", (event) =>
  console.error(`policy: ${event.violatedDirective} ${event.sourceFile}:${event.lineNumber}`));"""
PLOTS = "() => Bokeh.documents.filter((one) => one.roots().length).at(-1).roots()"
RANGES = f"() => ({PLOTS})().map((one) => [one.x_range.start, one.x_range.end, one.y_range.start, one.y_range.end])"
VISIBLE = f"() => ({PLOTS})().map((one) => one.renderers.map((each) => each.visible))"
INK = f"() => ({PLOTS})().map((one) => [one.left[0].axis_label_text_color, one.renderers[0].glyph.line_color.value])"
WORDS = """async () => {  // what is written on canvases from now on, with its place
  window.written = [];
  const fillText = CanvasRenderingContext2D.prototype.fillText;
  CanvasRenderingContext2D.prototype.fillText = function (text, x, y) {
    const { width } = this.measureText(text);
    const left = { left: x, right: x - width, center: x - width / 2 }[this.textAlign];
    window.written.push({ host: this.canvas.parentElement.parentElement.id, text, left, right: left + width, y });
    return fillText.call(this, text, x, y);
  };
}"""


@pytest.fixture
def data(data):
    """Two sines of 8 and 4 mm, at 1 and 2 Hz."""
    t = np.arange(1000) / 100.0
    for name, amplitude, frequency in (("first", 8e-3, 1.0), ("second", 4e-3, 2.0)):
        phase = 2 * np.pi * frequency * t
        record = records.Record(
            t, amplitude * np.sin(phase), 400.0 * np.tanh(3 * np.cos(phase)), voltage=1.0, name=name
        )
        records.write(records.with_velocity(record), data / f"{name}.h5")
    return data


@pytest.fixture
def records_page(address, new_page):
    """``records_page(tab)``: both records in a view of the Records page, drawn."""

    def open_at(tab="time", **settings):
        page = new_page(f"{address}#/records?source=data&open=data/first.h5&open=data/second.h5&tab={tab}", **settings)
        drawn(page)
        return page

    return open_at


def drawn(page):
    """Wait until there are charts with their tools, and no tool is still to come."""
    page.get_by_role("button", name="Save", exact=True).first.wait_for()


@pytest.mark.prove
@pytest.mark.quick
def test_a_zoom_in_one_chart_zooms_all_of_the_record(records_page):
    page = records_page()
    before = page.evaluate(RANGES)
    assert len(before) == 3
    place = page.get_by_role("img", name=re.compile("Velocity over time of first, second")).bounding_box()
    page.mouse.move(place["x"] + 0.4 * place["width"], place["y"] + 60)
    page.mouse.down()
    page.mouse.move(place["x"] + 0.5 * place["width"], place["y"] + 62, steps=4)
    page.mouse.up()
    page.wait_for_function(f"([[was]]) => ({RANGES})()[0][0] > was", arg=before)
    after = page.evaluate(RANGES)
    assert after[0][:2] == after[1][:2] == after[2][:2]
    assert after[0][1] - after[0][0] < 0.2 * (before[0][1] - before[0][0])
    page.get_by_role("button", name="Show all").click()
    assert page.evaluate(RANGES) == before
    page.mouse.move(place["x"] + 0.5 * place["width"], place["y"] + 60)
    page.mouse.wheel(0, -300)
    assert page.evaluate(RANGES) == before  # the page scrolls, until the wheel is told to zoom
    page.get_by_role("button", name="Wheel").click()
    page.mouse.move(place["x"] + 0.5 * place["width"], place["y"] + 62)
    page.mouse.wheel(0, -300)
    page.wait_for_function(f"([[was]]) => ({RANGES})()[0][0] > was", arg=before)


def test_a_name_in_the_legend_hides_its_lines_in_every_chart(records_page, reach):
    page = records_page()
    assert page.locator(".legend").count() == 1
    assert page.evaluate(VISIBLE) == [[True, True]] * 3
    wide = page.evaluate(RANGES)[0][2:]
    first = page.get_by_role("button", name="first", exact=True)
    reach(page, first)
    page.keyboard.press("Enter")
    assert first.get_attribute("aria-pressed") == "false"
    assert page.evaluate(VISIBLE) == [[False, True]] * 3
    low, high = page.evaluate(RANGES)[0][2:]
    assert high - low == pytest.approx((wide[1] - wide[0]) / 2, rel=0.01)  # 4 mm are left of 8
    page.keyboard.press("Enter")
    assert page.evaluate(VISIBLE) == [[True, True]] * 3
    assert page.evaluate(RANGES)[0][2:] == wide


def test_spectra_are_logarithmic(records_page):
    page = records_page("spectra")
    (scales,) = page.evaluate(f"() => ({PLOTS})().map((one) => [one.x_scale.type, one.y_scale.type])")
    assert scales == ["LogScale", "LogScale"]
    ((left, right, low, high),) = page.evaluate(RANGES)
    assert 1 / 3 <= left < 0.6  # of the slower excitation, 1 Hz, which does not stand on the edge
    assert 48 < right <= 50
    assert 0 < low < 1 < 100 < high
    page.get_by_text("9 whole cycles; 19 whole cycles").wait_for()
    row = page.get_by_role("tabpanel").locator("tr", has_text="second").locator("td").all_inner_texts()
    assert row[:3] == ["second", "19 whole cycles", "1.998"]
    assert float(row[5]) == pytest.approx(23.2, abs=0.5)  # %, the third harmonic of tanh(3 cos)
    page.get_by_label("All frequencies").check()
    page.wait_for_function(f"() => ({RANGES})().at(-1)?.[0] < 0.2")


def test_the_pick_up_fills_its_chart(records_page):
    page = records_page("cycles")
    ((left, right, low, high),) = page.evaluate(RANGES)
    assert 45 < left < 50.27 < right < 56  # mm/s, of both directions and both records
    assert right - left < 10
    assert 0 < low < 398 < high
    page.get_by_text("both without their signs").wait_for()


def test_no_metres_stand_beside_millimetres(records_page):
    page = records_page()
    page.get_by_role("tab", name="About").click()
    page.get_by_text("whole cycles").first.wait_for()
    text = page.locator("dl.facts").first.inner_text()
    assert "mm" in text
    assert not re.search(r"\d m(/s)?\b", text)


def test_charts_follow_the_theme(records_page):
    page = records_page(color_scheme="light")
    assert page.evaluate(INK) == [["#1b2026", "#d55e00"]] * 3
    page.evaluate("() => Bokeh.documents.at(-1).roots()[0].x_range.setv({ start: 2, end: 3 })")
    knob = page.get_by_role("button", name=re.compile("Colours"))
    knob.click()
    knob.click()
    assert page.evaluate(INK) == [["#e6e9ec", "#ff8a3d"]] * 3
    assert page.evaluate(RANGES)[2][:2] == [2, 3]  # drawn anew, and still zoomed


def test_a_reading_has_its_units(records_page):
    page = records_page()
    place = page.get_by_role("img", name=re.compile("Displacement over time")).bounding_box()
    frame = page.evaluate("() => { const { left, top } = Bokeh.index.roots[0].frame.bbox; return [left, top]; }")
    assert frame[0] == 72  # all frames begin at the same place
    page.mouse.move(place["x"] + 0.5 * place["width"], place["y"] + 60)
    page.mouse.move(place["x"] + 0.5 * place["width"] + 3, place["y"] + 60)
    assert page.locator(".hair:visible").count() == 3  # the same time in every chart
    words = page.locator(".tip:visible").inner_text().splitlines()
    assert words[0] in ("first", "second")
    assert re.fullmatch(r"time [\d.]+ s", words[1])
    assert re.fullmatch(r"displacement −?[\d.]+ mm", words[2])


def test_a_picture_is_saved(records_page, tmp_path):
    page = records_page()
    page.wait_for_function("() => Bokeh.documents.at(-1).is_idle")
    with page.expect_download() as download:
        page.get_by_role("button", name="Save", exact=True).click()
    download.value.save_as(tmp_path / "picture.png")
    assert download.value.suggested_filename == "displacement-over-time-of-first-second.png"
    header = (tmp_path / "picture.png").read_bytes()[:24]
    width, height = (int.from_bytes(header[k : k + 4], "big") for k in (16, 20))
    assert width > 400
    assert height > 210 + 210 + 250


def test_a_finger_scrolls_until_it_is_told_to_zoom(records_page):
    page = records_page(has_touch=True, is_mobile=True, viewport={"width": 390, "height": 844})
    active = "() => Bokeh.documents.at(-1).roots()[0].toolbar.tools.map((one) => one.active)"
    assert not any(page.evaluate(active))
    page.get_by_role("button", name="Zoom", exact=True).tap()
    assert any(page.evaluate(active))
    assert page.evaluate("() => document.documentElement.scrollWidth") <= 390


STYLES = """() => {  // of every shadow root: its style elements, and its constructed style sheets
  const roots = [];
  const visit = (node) => {
    for (const { shadowRoot } of node.querySelectorAll("*")) {
      if (!shadowRoot) continue;
      roots.push([shadowRoot.querySelectorAll("style").length, shadowRoot.adoptedStyleSheets.length]);
      visit(shadowRoot);
    }
  };
  visit(document);
  return roots;
}"""


@pytest.mark.prove
def test_the_policy_is_kept_and_nothing_is_asked_of_others(address, new_page, accessible):
    """`new_page` fails on every error and warning, and on every request to another machine."""
    page = new_page(address)
    page.evaluate(VIOLATIONS)
    where = "#/records?source=data&open=data/first.h5&open=data/second.h5&reference=data/first.h5"
    page.evaluate("where => location.assign(where)", where)
    for tab in ("Loops", "Spectra", "Cycles", "Acceptance", "Time"):
        page.get_by_role("tab", name=tab).click()
        drawn(page)
        styles = page.evaluate(STYLES)
        assert styles
        assert all(inline == 0 and adopted > 0 for inline, adopted in styles)
    accessible(page)


@pytest.mark.prove
def test_the_envelope_shows_the_tests_where_they_are(address, new_page):
    page = new_page(address)
    page.evaluate(VIOLATIONS)
    page.evaluate("() => location.assign('#/campaigns')")
    page.locator("#verdict").wait_for()
    page.locator("#g-amplitude").fill("4, 8")
    page.locator("#g-frequency").fill("0.5, 2")
    page.locator("#g-voltage").fill("0, 1.98")
    page.get_by_role("img", name=re.compile("and 8 tests; 2 of them are refused")).wait_for()
    drawn(page)
    points = page.evaluate(f"""() => ({PLOTS})()[0].renderers.filter((one) => one.glyph.type === "Scatter")
      .map(({{ data_source: {{ data }} }}) => [...data.x].map((x, k) => [x, data.y[k], data.size[k]]))""")
    low, high, crosses = points
    assert sorted(x for x, _, _ in low) == pytest.approx([0.5, 0.5, 2, 2], rel=1e-3)
    assert [one[:2] for one in low] == [one[:2] for one in high]  # none is moved aside
    assert low[0][2] < high[0][2]
    assert [round(x, 2) for x, _, _ in crosses] == [2, 2]
    assert max(size for _, _, size in crosses) > high[0][2]  # a cross is not hidden by what it crosses out
    names = page.locator(".envelope .legend button").all_inner_texts()
    assert names[-3:] == ["0 V", "1.98 V", "refused"]
    assert all(re.fullmatch(r"limit at \d+ N", name) for name in names[:-3])
    dashes = page.evaluate(f"""() => ({PLOTS})()[0].renderers.filter((one) => one.glyph.type === "Line")
      .map((one) => JSON.stringify(one.glyph.line_dash.value ?? one.glyph.line_dash))""")
    assert len(set(dashes)) == len(dashes) > 1  # not told apart by their width


def test_pages_without_charts_do_not_load_the_library(address, new_page):
    page = new_page(f"{address}#/records?source=data")
    page.get_by_text("Choose one or more records").wait_for()
    assert page.evaluate("() => typeof Bokeh") == "undefined"


def test_without_the_package_a_sentence_says_what_to_install(data, new_page, monkeypatch, request):
    monkeypatch.setattr(application, "find_spec", lambda name: None)
    page = new_page(f"{request.getfixturevalue('address')}#/records?source=data&open=data/first.h5")
    page.get_by_role("alert").get_by_text(
        'Charts need the package bokeh, which is not installed: run pip install "dampyr[console]"'
    ).wait_for()
    page.get_by_role("tab", name="About").click()
    page.get_by_text("whole cycles").wait_for()  # the rest works


AXES = [
    ([5.0, 5.001], {"least": 1}, (4.5005, 5.5005)),  # a constant signal, not its noise
    ([0.0, 10.0], {"least": 1, "pad": 0.1}, (-1, 11)),
    ([1.98, 1.98], {}, (1.97901, 1.98099)),
    ([0.0, 0.0], {}, (-0.5, 0.5)),
    ([], {}, (0, 1)),
    ([2.0, 8.0], {"zero": True}, (0, 8)),
    ([0.0, 0.1, 100.0], {"log": True}, (0.1, 100)),
    ([3.0], {"log": True}, (1.5, 6)),
    ([-1.0, 0.0], {"log": True}, (1, 10)),
]
COLUMNS = [
    ([24.4, 38.89, 22.81], 4, ["24.40", "38.89", "22.81"]),
    ([1, 12, 3], 4, ["1", "12", "3"]),
    ([0, -0.001, 12.5], 3, ["0.000", "−0.001", "12.500"]),
    ([0.9967, 0.007097, 0.0], 4, ["0.9967", "0.0071", "0.0000"]),
    ([2988.2, 1033.4], 4, ["2988", "1033"]),
    ([2e-9, 3.0], 4, ["2·10⁻⁹", "3"]),
]


def test_an_axis_is_never_narrower_than_its_least_span(address, new_page):
    page = new_page(address)
    call = "async ([values, axis]) => (await import('/static/lib/chart.js')).extent([values], axis)"
    for values, axis, ends in AXES:
        assert page.evaluate(call, [values, axis]) == pytest.approx(ends), (values, axis)


def test_numbers_of_a_column_have_the_same_decimals(address, new_page):
    page = new_page(address)
    call = """async ([values, digits]) => {
      const { table } = await import("/static/lib/table.js");
      const made = table({ columns: [{ name: "a", digits }], rows: values.map((value) => [value]) });
      return [...made.querySelectorAll("td")].map((cell) => cell.textContent);
    }"""
    for values, digits, shown in COLUMNS:
        assert page.evaluate(call, [values, digits]) == shown


STRIPS = """async (given) => {
  const { strip } = await import("/static/lib/strip.js");
  for (const [id, { low, high, ...options }] of Object.entries(given.strips)) {
    const host = Object.assign(document.createElement("div"), { id });
    document.querySelector("main").append(host);
    const time = low.map((_, k) => given.now - 5 + k / 10);
    strip(host, options).set({ now: given.now, span: 12, origin: given.origin, lines: [{ time, low, high }] });
  }
  await new Promise((done) => setTimeout(done, 300));
  return window.written;
}"""


def test_strips_share_their_times_and_do_not_zoom_into_noise(address, new_page):
    page = new_page(address)
    page.get_by_role("heading", level=1).wait_for()
    page.evaluate(WORDS)
    noise = [133.0 + 0.2 * (k % 3) for k in range(50)]
    swing = [12 * np.sin(k / 5) for k in range(50)]
    force = {"label": "force, live", "y": {"words": "force", "unit": "N", "least": 50}, "low": noise, "high": noise}
    limits = [{"value": 10, "words": "warning"}, {"value": 40, "words": "stroke"}]
    position = {
        "label": "position, live",
        "y": {"words": "position", "unit": "mm", "least": 2},
        "low": swing,
        "high": swing,
    }
    given = {"now": 57.3, "origin": None, "strips": {"a": force, "b": position | {"limits": limits}}}
    written = page.evaluate(STRIPS, given)
    a, b = ({one["text"]: one for one in written if one["host"] == host and one["y"] < 109} for host in "ab")
    first, second = (
        {one["text"]: one["left"] for one in written if one["host"] == host and one["y"] == 109} for host in "ab"
    )
    times = ["−12", "−10", "−8", "−6", "−4", "−2", "0"]
    assert first == second
    assert sorted(first) == sorted(times)
    numbers = [float(text.replace("−", "-")) for text in a if re.fullmatch(r"[−\d.]+", text) and text not in times]
    assert max(numbers) - min(numbers) >= 40
    assert "warning 10 mm" in b
    assert "↑ stroke 40 mm" in b
    for of in (a, b):
        title = next(one for text, one in of.items() if text.endswith(("[N]", "[mm]")))
        for text, one in of.items():
            assert one is title or abs(one["y"] - title["y"]) >= 10 or one["left"] > title["right"], text
    label = page.locator("#a .strip").get_attribute("aria-label")
    assert label == "force, live: now 133, from 133 to 133 N"


def test_strips_count_from_the_start_of_a_test(address, new_page):
    page = new_page(address)
    page.get_by_role("heading", level=1).wait_for()
    page.evaluate(WORDS)
    flat = [1.0] * 50
    one = {"label": "coil", "y": {"words": "coil", "unit": "V"}, "low": flat, "high": flat}
    texts = [each["text"] for each in page.evaluate(STRIPS, {"now": 57.3, "origin": 50.0, "strips": {"a": one}})]
    assert [text for text in ("−4", "−2", "0", "2", "4", "6") if text in texts] == ["−4", "−2", "0", "2", "4", "6"]
    assert "time since the start [s]" in texts


def test_a_strip_is_drawn_in_the_colours_of_the_page(address, new_page):
    page = new_page(address, color_scheme="light")
    page.get_by_role("heading", level=1).wait_for()
    flat = [1.0] * 50
    one = {"label": "coil", "series": [{"colour": "purple"}], "y": {"words": "coil"}, "low": flat, "high": flat}
    page.evaluate(STRIPS, {"now": 57.3, "origin": None, "strips": {"a": one}})
    has = """(wanted) => {
      const canvas = document.querySelector("#a canvas");
      const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d", { willReadFrequently: true });
      copy.drawImage(canvas, 0, 0);
      const { data } = copy.getImageData(0, 0, canvas.width, canvas.height);
      for (let k = 0; k < data.length; k += 4)
        if (wanted.every((value, j) => Math.abs(data[k + j] - value) < 6) && data[k + 3] > 100) return true;
      return false;
    }"""
    assert page.evaluate(has, [0xCC, 0x79, 0xA7])
    page.emulate_media(color_scheme="dark")
    page.wait_for_function(has, arg=[0xDD, 0x9C, 0xC0])
