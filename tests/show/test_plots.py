"""Figures of a result in pyplot: the one of its description, with the mark of its origin, or a sentence why there is none."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest

from dampyr.errors import InputError
from dampyr.origin import SIMULATED, Origin
from dampyr.show.descriptions import Description, describe
from dampyr.show.figures.ground_motion import ground_motion
from dampyr.show.plots import plots_of
from dampyr.shown import Shown


@dataclass(frozen=True, repr=False)
class Knock(Shown):
    """A result with a figure, unless it is silent."""

    acceleration: tuple[float, ...]
    origin: Origin = SIMULATED


class Silence(Shown):
    """A result without a figure."""


@describe.register
def describe_knock(knock: Knock) -> Description:
    time = np.arange(len(knock.acceleration))
    return Description("Knock", figure=lambda: ground_motion(time, knock.acceleration) if len(time) else None)


@describe.register
def describe_silence(silence: Silence) -> Description:
    return Description("Silence")


@pytest.fixture(autouse=True)
def _closed() -> Iterator[None]:
    from matplotlib import pyplot

    yield
    pyplot.close("all")


def test_the_figure_is_one_of_pyplot_and_bears_the_mark_of_the_origin() -> None:
    from matplotlib import pyplot

    pyplot.close("all")
    [panel] = Knock((0.0, 2.0, -1.0)).plot()
    np.testing.assert_array_equal(panel.lines[0].get_ydata(), [0.0, 2.0, -1.0])
    assert pyplot.figure(pyplot.get_fignums()[0]) is panel.figure
    assert [text.get_text() for text in panel.figure.texts] == ["SIMULATED"]
    assert Knock((0.0, 1.0), Origin("measured")).plot()[0].figure.texts == []


def test_a_result_without_anything_to_draw_says_so() -> None:
    with pytest.raises(InputError, match="this Knock has nothing to draw"):
        Knock(()).plot()
    assert plots_of(Silence()) is None
    with pytest.raises(AttributeError, match="Silence has no figure to plot"):
        _ = Silence().plot
