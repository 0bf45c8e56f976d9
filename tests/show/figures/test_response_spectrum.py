"""A response spectrum over its periods."""

from tests.show.figures.figure_examples import MAKERS, lines


def test_a_spectrum_tells_its_peak_and_shows_its_periods() -> None:
    fig = MAKERS["spectrum"]()
    assert "2 %: 0.032 m/s² at 0.5 s" in lines(fig)
    assert [label.get_text() for label in fig.axes[0].get_xticklabels()] == ["0.05", "0.1", "0.2", "0.5", "1", "2"]
