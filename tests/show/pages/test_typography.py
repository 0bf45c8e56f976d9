"""Powers of ten and symbols of parameters in plain texts."""

import pytest

from dampyr.show.figures.symbols import as_mathtext, in_law_words, law_in_words, symbol
from dampyr.show.pages.blocks import Section, Text
from dampyr.show.pages.html_page import page
from dampyr.show.pages.typography import as_html, as_words, with_powers
from dampyr.show.table import Table
from dampyr.structures import available_control_laws


@pytest.mark.parametrize(
    ("text", "read"),
    [
        ("more than 1e-8 of it", "more than 1·10⁻⁸ of it"),
        ("p = 9e-08.", "p = 9·10⁻⁸."),
        ("6.57e+04 N", "6.57·10⁴ N"),
        ("2.5e-10", "2.5·10⁻¹⁰"),
        ("run_1e-8.h5", "run_1e-8.h5"),
        ("the file 1e3 and 3e", "the file 1e3 and 3e"),
        ("v1.2e-3x", "v1.2e-3x"),
    ],
)
def test_powers_of_ten_are_written_out(text: str, read: str) -> None:
    assert with_powers(text) == read


@pytest.mark.parametrize(
    ("text", "read"),
    [
        ("dahl.kx", 'dahl <var title="dahl.kx">k<sub>x</sub></var>'),
        ("dahl.rho @ 1.98 V", 'dahl <var title="dahl.rho">ρ</var> at 1.98 V'),
        ("modified_bouc_wen.sigma", 'modified bouc wen <var title="modified_bouc_wen.sigma">σ</var>'),
        ("lugre.sigma1.", 'lugre <var title="lugre.sigma1">σ<sub>1</sub></var>.'),
        ("dahl.kxy", "dahl.kxy"),
        ("a/dahl.kx, dahl.kx.toml", "a/dahl.kx, dahl.kx.toml"),
        ("dampyr.identification.fit", "dampyr.identification.fit"),
        ("kx and kw.", '<var title="kx">k<sub>x</sub></var> and <var title="kw">k<sub>w</sub></var>.'),
        ("(rho)", '(<var title="rho">ρ</var>)'),
        ("kx.toml, okx, kx_2, a/kx", "kx.toml, okx, kx_2, a/kx"),
        ("<b>dahl.n</b>", "&lt;b&gt;dahl.n&lt;/b&gt;"),
    ],
)
def test_names_of_parameters_are_set_as_symbols(text: str, read: str) -> None:
    assert as_html(text) == read


@pytest.mark.parametrize(
    ("name", "drawn"),
    [
        ("kx", r"$k_\mathit{x}$"),
        ("rho", "$ρ$"),
        ("spring.k0", r"spring $k_\mathit{0}$"),
        ("force", "force"),
        ("c", "$c$"),
    ],
)
def test_symbols_of_figures(name: str, drawn: str) -> None:
    assert as_mathtext(name) == drawn


def test_a_word_is_no_symbol() -> None:
    assert symbol("mass") is None
    assert symbol("kappa") == ("κ", "")


def test_a_page_sets_its_texts_and_sorts_by_what_was_given() -> None:
    table = Table(("parameter", "p"), [["dahl.kx", "9e-08"]], caption="Below 1e-5.")
    html = page("1e-8", [Section("About dahl.rho", [Text("By 1e-8."), table])])
    for shown in (
        "<h1>1·10⁻⁸</h1>",
        "By 1·10⁻⁸.",
        "Below 1·10⁻⁵.",
        ">9·10⁻⁸</td>",
        '<var title="dahl.rho">ρ</var></h2>',
    ):
        assert shown in html
    assert 'data-key="dahl.kx"' in html
    assert 'data-key="9e-08"' in html


def test_laws_and_parameters_are_words_on_paper_in_figures_and_on_pages() -> None:
    from matplotlib.figure import Figure

    assert not [words for words in map(law_in_words, available_control_laws()) if "_" in words]
    assert [law_in_words(name) for name in ("bang_bang", "clipped_optimal_lqg", "lyapunov")] == [
        "bang-bang", "clipped-optimal LQG", "Lyapunov"
    ]  # fmt: skip
    said = "clipped_optimal 0 to 3.2 V, lag 0.01 s; lyapunov 0 to 1e-3 V against --control bang_bang in bang_bang.py"
    words = "clipped-optimal 0 to 3.2 V, lag 0.01 s; Lyapunov 0 to 1e-3 V against --control bang_bang in bang_bang.py"
    assert as_words(said) == words
    assert as_html(said) == words.replace("1e-3", "1·10⁻³")
    assert as_words("dahl.kx @ 1.98 V and rho of bouc_wen.kw in ensaio.A.1, kx.h5") == (
        "dahl k_x at 1.98 V and ρ of bouc wen k_w in ensaio.A.1, kx.h5"
    )
    figure = Figure()
    axes = figure.subplots()
    axes.plot([0, 1], label="bang_bang 0 to 3 V")
    axes.legend()
    in_law_words(figure)
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["bang-bang 0 to 3 V"]
